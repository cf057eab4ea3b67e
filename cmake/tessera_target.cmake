# One place for what every target of ours is compiled with.

add_library(tessera_options INTERFACE)
target_compile_features(tessera_options INTERFACE cxx_std_20)
target_include_directories(tessera_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(tessera_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow
  # Without this a compiler may fuse a*b+c on machines that have fma, and lists would differ between machines.
  -ffp-contract=off
  -fno-math-errno)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees overlapping copies in std::string's operator+ (GCC bug 105651).
  target_compile_options(tessera_options INTERFACE -Wno-restrict)
endif()
if(TESSERA_WERROR)
  target_compile_options(tessera_options INTERFACE -Werror)
endif()
if(TESSERA_SCALAR)
  target_compile_definitions(tessera_options INTERFACE HWY_COMPILE_ONLY_SCALAR EIGEN_DONT_VECTORIZE)
  target_compile_options(tessera_options INTERFACE -fno-tree-vectorize)
endif()
if(TESSERA_SANITIZE)
  target_compile_options(tessera_options INTERFACE -fsanitize=${TESSERA_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(tessera_options INTERFACE -fsanitize=${TESSERA_SANITIZE})
  if(TESSERA_SANITIZE MATCHES thread)
    # Asio's fences are not understood by ThreadSanitizer; GCC says so at each.
    target_compile_options(tessera_options INTERFACE -Wno-tsan)
  endif()
endif()

# tessera_library(NAME SOURCES a.cpp b.cpp DEPENDS lib... [PRIVATE_DEPENDS lib...])
function(tessera_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC tessera_options ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
endfunction()

# tessera_test(NAME SOURCES a.cpp DEPENDS lib... [LABELS l...] [TIMEOUT_S n]): one GoogleTest program.
# A test that cannot run calls GTEST_SKIP with its reason; ctest then reports it as skipped.
function(tessera_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT_S" "SOURCES;DEPENDS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT_S)
    set(ARG_TIMEOUT_S 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE tessera_options ${ARG_DEPENDS} GTest::gtest_main)
  # Test code runs once and is compiled everywhere: short builds matter more than fast tests.
  target_compile_options(${name} PRIVATE -O1)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  include(GoogleTest)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT ${ARG_TIMEOUT_S} LABELS "${ARG_LABELS}"
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endfunction()

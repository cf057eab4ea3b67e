#include "common/cull/footprint/kernels.h"

// Every instruction set is compiled, not only those above the baseline, so that one can be forced.
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/cull/footprint/kernels.cpp"
#include <hwy/foreach_target.h>
// foreach_target comes first.
#include <hwy/highway.h>

#include "common/cull/footprint/kernels-inl.h"

#if HWY_ONCE

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

namespace tessera::cull {

namespace {

HWY_EXPORT(makeKernels);

constexpr double kUnitRoundoffFloat = 0x1p-24;

float up(double x) {
  const auto nearest = static_cast<float>(x);
  return double{nearest} < x ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}
float down(double x) {
  return -up(-x);
}

double largest(const std::array<float, 3>& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

struct Target {
  std::string_view name;
  std::int64_t bit;
};
constexpr std::array kTargets = {Target{"avx512", HWY_AVX3}, Target{"avx2", HWY_AVX2},
                                 Target{"sse4", HWY_SSE4}, Target{"neon", HWY_NEON},
                                 Target{"scalar", HWY_SCALAR}};

/// What this program has and this machine can run.
std::int64_t available() {
  static const std::int64_t targets = hwy::SupportedTargets() & (HWY_TARGETS);
  return targets | ((HWY_TARGETS)&HWY_SCALAR);
}

Kernels choose(std::string_view name) {
  std::int64_t mask = available();
  for (const Target& target : kTargets) {
    if (target.name == name) mask = target.bit;
  }
  hwy::SetSupportedTargetsForTest(mask);
  hwy::GetChosenTarget().Update(mask);
  return HWY_DYNAMIC_DISPATCH(makeKernels)();
}

std::string wish() {
  const char* text = std::getenv("TESSERA_SIMD");
  return text ? text : "";
}

bool isHere(std::string_view name) {
  const auto here = instructionSets();
  return name.empty() || std::find(here.begin(), here.end(), name) != here.end();
}

struct Chosen {
  Kernels kernels;
  std::string_view name;
};
Chosen chosenNamed(std::string_view name) {
  const auto here = instructionSets();
  const auto found = std::find(here.begin(), here.end(), name);
  const std::string_view taken = found == here.end() ? here.front() : *found;
  return {choose(taken), taken};
}

Chosen& chosen() {
  static Chosen current = chosenNamed(wish());
  return current;
}

}  // namespace

KernelFrame KernelFrame::make(const GridCoordinates& grid, double scale, double errors) {
  constexpr double u = kUnitRoundoffFloat;
  KernelFrame frame = {};
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    frame.eye[i] = grid.eye[i];
    frame.column[i] = grid.column[at];
    frame.row[i] = grid.row[at];
    frame.depth[i] = grid.depth[at];
  }
  frame.scale = scale;
  const double fx = largest(grid.column), fy = largest(grid.row), fz = largest(grid.depth);
  frame.columnError = up(errors * u * (8 * fx + 16 * (grid.columns + 2) * fz));
  frame.rowError = up(errors * u * (8 * fy + 16 * (grid.rows + 2) * fz));
  frame.frontError = up(256 * errors * u * fz);
  frame.depthError = up(errors * (8 * u * fz + grid.depthError));
  // 2^11: a leaf before the eye is taken where zmin >= zmax / 1024, and its error is relative to zmin.
  frame.sideError =
      up(0x1p11 * errors * u * (8 * std::max(fx, fy) + 16 * (std::max(grid.columns, grid.rows) + 2) * fz));
  const bool isLeaf = errors <= 1;  // what a node decides, its leaves decide
  frame.depthRatio = isLeaf ? 0x1p-10F : 0x1p-9F;
  frame.mostSize = isLeaf ? 0x1p50F : 0x1p49F;
  frame.leastDepth = isLeaf ? 0x1p-50F : 0x1p-49F;
  frame.near = down(grid.nearDepth * scale);
  frame.far = up(grid.farDepth * scale);
  frame.columnLow = down(grid.columnLow);
  frame.columnHigh = up(grid.columnHigh);
  frame.rowLow = down(grid.rowLow);
  frame.rowHigh = up(grid.rowHigh);
  frame.valueError = std::max(frame.columnError, frame.rowError);
  frame.farError = up(32 * errors * u * fz);
  frame.lastColumn = static_cast<float>(grid.columns - 1);
  frame.lastRow = static_cast<float>(grid.rows - 1);
  return frame;
}

const Kernels& kernels() {
  return chosen().kernels;
}

std::vector<std::string_view> instructionSets() {
  std::vector<std::string_view> names;
  for (const Target& target : kTargets) {
    if (available() & target.bit) names.push_back(target.name);
  }
  return names;
}

std::string_view instructionSet() {
  return chosen().name;
}

Status chooseInstructionSet(std::string_view name) {
  if (!isHere(name)) {
    std::string known;
    for (const std::string_view here : instructionSets())
      known += (known.empty() ? "" : ", ") + std::string(here);
    return inputError("TESSERA_SIMD", "this machine has no instruction set \"" + std::string(name) + "\"",
                      "choose one of " + known + ", or leave it unset");
  }
  chosen() = chosenNamed(name);
  return Done{};
}

Status checkInstructionSetWish() {
  const std::string wished = wish();
  return isHere(wished) ? Status(Done{}) : chooseInstructionSet(wished);
}

}  // namespace tessera::cull

#endif  // HWY_ONCE

#include "common/base/file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <unistd.h>

namespace tessera {

namespace fs = std::filesystem;

Result<std::string> readFile(const fs::path& path, std::uintmax_t limitBytes) {
  std::error_code ec;
  const fs::file_status status = fs::status(path, ec);
  if (!fs::exists(status)) return inputError(path.string(), "no such file", "check the path");
  if (fs::is_directory(status)) return inputError(path.string(), "is a folder", "name a file in it");
  std::ifstream in(path, std::ios::binary);
  if (!in) return inputError(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
  // Sizes of pipes and devices are unknown beforehand, so the limit is held while reading.
  std::string bytes;
  char block[1 << 16];
  while (in.read(block, sizeof block) || in.gcount() > 0) {
    bytes.append(block, static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > limitBytes) {
      return inputError(path.string(), "is larger than " + std::to_string(limitBytes) + " bytes",
                        "is it the right file?");
    }
  }
  if (in.bad()) return inputError(path.string(), std::string("cannot be read: ") + std::strerror(errno));
  return bytes;
}

Status writeFileAtomically(const fs::path& path, std::string_view bytes) {
  fs::path partial = path;
  partial += "." + std::to_string(::getpid()) + ".tmp";
  const auto fail = [&](const std::string& what) -> Status {
    const std::string reason = std::strerror(errno);
    std::error_code ignored;
    fs::remove(partial, ignored);
    return runtimeError(path.string(), what + ": " + reason);
  };
  {
    std::ofstream out(partial, std::ios::binary | std::ios::trunc);
    if (!out) return fail("cannot be created");
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) return fail("cannot be written");
  }
  std::error_code ec;
  fs::rename(partial, path, ec);
  if (ec) {
    errno = ec.value();
    return fail("cannot be put in place");
  }
  return Done{};
}

}  // namespace tessera

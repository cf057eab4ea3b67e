#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace tessera {

/// Reads a whole regular file. The error names the file and says why (missing, a folder, no right, over
/// `limitBytes`).
[[nodiscard]] Result<std::string> readFile(const std::filesystem::path& path, std::uintmax_t limitBytes);

/// Writes `bytes` beside `path` and renames it there, so that nobody ever sees half a file.
[[nodiscard]] Status writeFileAtomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace tessera

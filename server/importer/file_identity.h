#pragma once

#include <filesystem>
#include <string>

#include "common/assets/disk_store.h"
#include "common/base/result.h"

namespace tessera {

/// SHA-256 of a file's content, in hex. Empty where there is no such file.
[[nodiscard]] Result<std::string> hashFile(const std::filesystem::path& path);

/// The same, remembered in the store by what the machine says of the file (device, inode, size, times of
/// change): a large scene that has not been touched is not read again. What changed in the last two seconds
/// is not remembered, as the clock of files may not tell two changes apart.
[[nodiscard]] Result<std::string> hashFile(const std::filesystem::path& path, DiskStore& memory);

/// SHA-256 of a text, in hex.
[[nodiscard]] std::string hashText(const std::string& text);

}  // namespace tessera

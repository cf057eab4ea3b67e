#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "common/base/result.h"

namespace tessera {

/// The files in a zip archive, read into memory one by one.
class Archive {
 public:
  [[nodiscard]] static Result<Archive> open(const std::filesystem::path& path);

  /// The name as it stands in the archive, found whatever its case; empty: there is none.
  [[nodiscard]] std::string find(const std::string& name) const;
  /// The whole file. Fails where it holds more than `limitBytes` (whatever the archive says it holds), does
  /// not match its checksum or is encrypted. Names that lead out of the archive are refused.
  [[nodiscard]] Result<std::string> read(const std::string& name, std::int64_t limitBytes) const;
  /// "ARCHIVE(NAME)".
  [[nodiscard]] std::string place(const std::string& name) const;

 private:
  struct Close {
    void operator()(void* zip) const;
  };
  explicit Archive(std::string path) : path_(std::move(path)) {}

  std::string path_;
  std::unique_ptr<void, Close> zip_;
};

}  // namespace tessera

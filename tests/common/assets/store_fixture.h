#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/assets/disk_store.h"
#include "common/assets/store_folder.h"
#include "tests/support/process.h"

namespace tessera::test {

inline std::span<const std::byte> bytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

/// Bytes by seed; every second one packs well.
inline std::string someBytes(std::uint64_t seed, std::size_t bytes) {
  std::mt19937_64 random(seed);
  std::string text(bytes, '\0');
  for (std::size_t i = 0; i < bytes; ++i) {
    text[i] = static_cast<char>(seed % 2 == 0 ? random() & 0xff : (i / 16) & 0x7f);
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(bytes, sizeof seed); ++i) {
    text[i] = static_cast<char>(seed >> (8 * i));
  }
  return text;
}

inline std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

inline std::string contentOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void overwrite(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

/// Runs `body` in a child; its exit status is what `body` returns, 128 + signal where one ended it.
inline int inChild(const std::function<int()>& body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

class StoreTest : public ::testing::Test {
 protected:
  StoreTest() { options_.folder = folder_ / "store"; }

  [[nodiscard]] std::unique_ptr<DiskStore> open() const {
    auto store = DiskStore::open(options_);
    EXPECT_TRUE(store.ok()) << store.error().text();
    return store ? std::move(*store) : nullptr;
  }

  static AssetId put(DiskStore& store, const std::string& bytes, AssetKind kind = AssetKind::Drawable) {
    const AssetId id = assetIdOf(bytesOf(bytes));
    const auto place = store.add(id, kind, bytesOf(bytes));
    EXPECT_TRUE(place.ok()) << place.error().text();
    return id;
  }

  /// The bytes of an asset that find() gives; empty where it gives none or they cannot be read.
  static std::optional<std::string> get(const DiskStore& store, const AssetId& id) {
    const auto place = store.find(id);
    if (!place) return std::nullopt;
    auto bytes = store.read(id, *place);
    return bytes ? std::optional(*bytes) : std::nullopt;
  }

  [[nodiscard]] StoreFolder folder() const { return {options_.folder}; }

  TemporaryFolder folder_;
  DiskStore::Options options_;
};

}  // namespace tessera::test

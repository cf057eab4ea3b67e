#include "server/importer/file_identity.h"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <memory>
#include <vector>

#include <openssl/evp.h>
#include <sys/stat.h>

#include "common/assets/asset_id.h"

namespace tessera {

namespace {

constexpr std::size_t kBlockBytes = 1 << 20;
constexpr std::time_t kSettledS = 2;

struct stat statOf(const std::filesystem::path& path, bool& isThere) {
  struct stat facts {};
  isThere = ::stat(path.c_str(), &facts) == 0;
  return facts;
}

std::string nameOf(const struct stat& facts) {
  std::string text;
  for (const long long number :
       {static_cast<long long>(facts.st_dev), static_cast<long long>(facts.st_ino),
        static_cast<long long>(facts.st_size), static_cast<long long>(facts.st_mtim.tv_sec),
        static_cast<long long>(facts.st_mtim.tv_nsec), static_cast<long long>(facts.st_ctim.tv_sec),
        static_cast<long long>(facts.st_ctim.tv_nsec)})
    text += std::to_string(number) + " ";
  return "file-" + hashText(text);
}

}  // namespace

std::string hashText(const std::string& text) {
  return assetIdOf(std::as_bytes(std::span(text))).hex();
}

Result<std::string> hashFile(const std::filesystem::path& path) {
  std::error_code ec;
  if (!std::filesystem::exists(path, ec)) return std::string();
  // A pipe or a device may have no end.
  if (!std::filesystem::is_regular_file(path, ec)) return inputError(path.string(), "is not a file");
  std::ifstream file(path, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> sha(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  std::vector<char> block(kBlockBytes);
  EVP_DigestInit_ex(sha.get(), EVP_sha256(), nullptr);
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    EVP_DigestUpdate(sha.get(), block.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.eof()) return inputError(path.string(), "cannot be read", "check its rights");
  AssetId id;
  EVP_DigestFinal_ex(sha.get(), id.bytes.data(), nullptr);
  return id.hex();
}

Result<std::string> hashFile(const std::filesystem::path& path, DiskStore& memory) {
  bool isThere = false;
  const struct stat before = statOf(path, isThere);
  if (!isThere) return std::string();
  const std::string name = nameOf(before);
  if (const auto known = memory.mapEntry(name); known && *known && (*known)->bytes().size() == 64) {
    const auto bytes = (*known)->bytes();
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  auto hash = hashFile(path);
  if (!hash || hash->empty()) return hash;
  const bool hasSettled = std::time(nullptr) - before.st_ctim.tv_sec > kSettledS;
  if (hasSettled && nameOf(statOf(path, isThere)) == name && isThere) {
    // Not to remember costs time alone.
    (void)memory.putEntry(name, std::as_bytes(std::span(*hash)));
  }
  return hash;
}

}  // namespace tessera

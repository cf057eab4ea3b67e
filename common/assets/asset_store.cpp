#include "common/assets/asset_store.h"

#include <utility>

#include <openssl/sha.h>

namespace tessera {

std::string AssetId::hex() const {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::uint8_t b : bytes) {
    text.push_back(digits[b >> 4]);
    text.push_back(digits[b & 15]);
  }
  return text;
}

AssetId assetIdOf(std::span<const std::byte> bytes) {
  AssetId id;
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), id.bytes.data());
  return id;
}

AssetId AssetStore::add(Asset asset) {
  const AssetId id = assetIdOf(std::as_bytes(std::span(asset.bytes)));
  const std::uint64_t size = asset.bytes.size();
  if (assets_.try_emplace(id, std::move(asset)).second) bytes_ += size;
  return id;
}

const Asset* AssetStore::find(const AssetId& id) const {
  const auto found = assets_.find(id);
  return found == assets_.end() ? nullptr : &found->second;
}

}  // namespace tessera

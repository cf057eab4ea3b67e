#include "common/assets/asset_id.h"

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

}  // namespace tessera

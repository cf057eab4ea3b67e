#include "common/assets/stored_asset.h"

#include <cstdlib>

#include <unistd.h>

namespace tessera {

PackId PackId::random() {
  PackId id;
  if (::getentropy(id.bytes.data(), id.bytes.size()) != 0) std::abort();  // Linux always has it.
  return id;
}

std::optional<PackId> PackId::fromHex(std::string_view text) {
  PackId id;
  if (text.size() != 2 * id.bytes.size()) return std::nullopt;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    int digit;
    if (c >= '0' && c <= '9') {
      digit = c - '0';
    } else if (c >= 'a' && c <= 'f') {
      digit = c - 'a' + 10;
    } else {
      return std::nullopt;
    }
    id.bytes[i / 2] = static_cast<std::uint8_t>(id.bytes[i / 2] << 4 | digit);
  }
  return id;
}

std::string PackId::hex() const {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t b : bytes) {
    text.push_back(digits[b >> 4]);
    text.push_back(digits[b & 15]);
  }
  return text;
}

}  // namespace tessera

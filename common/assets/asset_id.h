#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

namespace tessera {

/// SHA-256 of an asset's bytes: its name everywhere.
struct AssetId {
  std::array<std::uint8_t, 32> bytes{};
  friend bool operator==(const AssetId&, const AssetId&) = default;
  friend auto operator<=>(const AssetId&, const AssetId&) = default;
  [[nodiscard]] std::string hex() const;
};

/// SHA-256 is uniform, so its first bytes are hash enough.
struct AssetIdHash {
  std::size_t operator()(const AssetId& id) const {
    std::size_t h;
    std::memcpy(&h, id.bytes.data(), sizeof h);
    return h;
  }
};

[[nodiscard]] AssetId assetIdOf(std::span<const std::byte> bytes);

}  // namespace tessera

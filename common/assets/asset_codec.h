#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// How the bytes of an asset are stored. Values go on disk and never change.
enum class AssetCodec : std::uint8_t { Raw = 0, Zstd = 1 };

/// Compresses where that pays: nothing unless at least a sixteenth is saved. May be called by many threads.
[[nodiscard]] std::optional<std::vector<std::byte>> compressAsset(std::span<const std::byte> bytes,
                                                                  int level);

/// The inverse for bytes from outside: nothing unless they unpack to exactly `bytes`. Allocates no more than
/// that, and that only where the compressed bytes say the same. May be called by many threads.
[[nodiscard]] std::optional<std::string> decompressAsset(std::span<const std::byte> stored,
                                                         std::size_t bytes);

}  // namespace tessera

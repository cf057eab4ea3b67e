#include "common/assets/asset_codec.h"

#include <memory>

#include <zstd.h>

namespace tessera {

namespace {

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

}  // namespace

std::optional<std::vector<std::byte>> compressAsset(std::span<const std::byte> bytes, int level) {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  const std::size_t limit = bytes.size() - bytes.size() / 16;
  if (!context || limit == bytes.size()) return std::nullopt;
  // What does not fit below the limit would not be kept anyway.
  std::vector<std::byte> out(limit);
  const std::size_t n =
      ZSTD_compressCCtx(context.get(), out.data(), out.size(), bytes.data(), bytes.size(), level);
  if (ZSTD_isError(n) != 0) return std::nullopt;
  out.resize(n);
  return out;
}

std::optional<std::string> decompressAsset(std::span<const std::byte> stored, std::size_t bytes) {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  if (!context || ZSTD_getFrameContentSize(stored.data(), stored.size()) != bytes) return std::nullopt;
  std::string out(bytes, '\0');
  const std::size_t n =
      ZSTD_decompressDCtx(context.get(), out.data(), out.size(), stored.data(), stored.size());
  if (ZSTD_isError(n) != 0 || n != bytes) return std::nullopt;
  return out;
}

}  // namespace tessera

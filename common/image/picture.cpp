#include "common/image/picture.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include <png.h>

#include "common/base/file.h"

namespace tessera {

namespace {

constexpr std::uintmax_t kMaxPngBytes = std::uintmax_t{1} << 30;
constexpr int kMaxSidePx = 65536;

void appendBytes(png_structp png, png_bytep bytes, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

/// libpng must not print; its error handler has to leave by longjmp or an exception.
struct PngFailure {
  std::string what;
};
[[noreturn]] void failPng(png_structp, png_const_charp message) {
  throw PngFailure{message};
}
void ignorePngWarning(png_structp, png_const_charp) {}

}  // namespace

void Picture::paste(int x, int y, int width, int height, std::span<const std::uint8_t> part) {
  if (x < 0 || y < 0 || x + width > widthPx || y + height > heightPx) std::abort();
  const std::size_t rowBytes = static_cast<std::size_t>(width) * 3;
  for (int row = 0; row < height; ++row) {
    const std::size_t to = (static_cast<std::size_t>(y + row) * static_cast<std::size_t>(widthPx) +
                            static_cast<std::size_t>(x)) *
                           3;
    std::memcpy(rgb.data() + to, part.data() + static_cast<std::size_t>(row) * rowBytes, rowBytes);
  }
}

Result<std::string> encodePng(const Picture& picture) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, failPng, ignorePngWarning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  try {
    if (!info) throw PngFailure{"out of memory"};
    png_set_write_fn(png, &bytes, appendBytes, nullptr);
    png_set_compression_level(png, 2);
    png_set_filter(png, 0, PNG_FILTER_SUB);
    png_set_IHDR(png, info, static_cast<png_uint_32>(picture.widthPx),
                 static_cast<png_uint_32>(picture.heightPx), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    const std::size_t rowBytes = static_cast<std::size_t>(picture.widthPx) * 3;
    for (int row = 0; row < picture.heightPx; ++row) {
      png_write_row(png, picture.rgb.data() + static_cast<std::size_t>(row) * rowBytes);
    }
    png_write_end(png, info);
  } catch (const PngFailure& failure) {
    png_destroy_write_struct(&png, &info);
    return runtimeError("PNG", failure.what);
  }
  png_destroy_write_struct(&png, &info);
  return bytes;
}

Result<Picture> readPng(const std::filesystem::path& path) {
  const auto bytes = readFile(path, kMaxPngBytes);
  if (!bytes) return bytes.error();
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, bytes->data(), bytes->size())) {
    return inputError(path.string(), std::string("is not a PNG picture: ") + image.message);
  }
  if (image.width > kMaxSidePx || image.height > kMaxSidePx) {
    png_image_free(&image);
    return inputError(path.string(), "is larger than 65536 pixels on a side");
  }
  image.format = PNG_FORMAT_RGB;
  Picture picture(static_cast<int>(image.width), static_cast<int>(image.height));
  if (!png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr)) {
    return inputError(path.string(), std::string("is a damaged PNG picture: ") + image.message);
  }
  return picture;
}

Result<PictureDifference> compare(const Picture& a, const Picture& b) {
  if (a.widthPx != b.widthPx || a.heightPx != b.heightPx)
    return inputError("", "the pictures differ in size");
  PictureDifference difference;
  difference.pixels = a.rgb.size() / 3;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(int{a.rgb[i + c]} - int{b.rgb[i + c]}));
    difference.differing += most > 0 ? 1 : 0;
    difference.differingMuch += most > 8 ? 1 : 0;
    difference.largest = std::max(difference.largest, most);
  }
  return difference;
}

}  // namespace tessera

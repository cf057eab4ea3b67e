#include "common/wall/mpcdi/maps.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include <png.h>

namespace tessera {

namespace {

constexpr std::string_view kSpace = " \t\r\n";

/// The next word of a header; the single byte of white space behind it is taken as well.
std::string_view headerWord(std::string_view bytes, std::size_t& at) {
  constexpr std::size_t kLongestHeader = 256;
  const std::string_view header = bytes.substr(0, kLongestHeader);
  const std::size_t begin = header.find_first_not_of(kSpace, at);
  if (begin == std::string_view::npos) return {};
  const std::size_t end = header.find_first_of(kSpace, begin);
  if (end == std::string_view::npos) return {};
  at = end + 1;
  return header.substr(begin, end - begin);
}

template <class T>
bool parseNumber(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && !text.empty();
}

std::string sizeText(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// What is wrong with the size of a map; empty: nothing.
std::string sizeFault(std::int64_t width, std::int64_t height) {
  if (width < 1 || height < 1 || width > kMaxMpcdiSidePx || height > kMaxMpcdiSidePx ||
      width * height > kMaxMpcdiMapSamples) {
    return "has " + sizeText(width, height) + " samples; 1 to " + std::to_string(kMaxMpcdiSidePx) +
           " a side and " + std::to_string(kMaxMpcdiMapSamples) + " in all are possible";
  }
  return {};
}

struct PngFailure {
  std::string what;
};
[[noreturn]] void failPng(png_structp, png_const_charp message) {
  throw PngFailure{message};
}
void ignorePngWarning(png_structp, png_const_charp) {}

struct PngSource {
  std::string_view rest;
};
void readPng(png_structp png, png_bytep bytes, png_size_t count) {
  PngSource& source = *static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source.rest.size()) failPng(png, "the file ends too early");
  std::memcpy(bytes, source.rest.data(), count);
  source.rest.remove_prefix(count);
}

class PngReader {
 public:
  PngReader() : png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, failPng, ignorePngWarning)) {
    if (png_) info_ = png_create_info_struct(png_);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  MpcdiMap read(std::string_view bytes) {
    if (!info_) throw PngFailure{"out of memory"};
    source_.rest = bytes;
    png_set_read_fn(png_, &source_, readPng);
    png_set_user_limits(png_, kMaxMpcdiSidePx, kMaxMpcdiSidePx);
    png_set_chunk_malloc_max(png_, 1 << 20);
    png_set_chunk_cache_max(png_, 16);
    png_read_info(png_, info_);
    const std::int64_t width = png_get_image_width(png_, info_), height = png_get_image_height(png_, info_);
    if (const std::string fault = sizeFault(width, height); !fault.empty()) throw PngFailure{fault};
    png_set_expand(png_);
    png_set_expand_16(png_);
    png_set_strip_alpha(png_);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    const std::size_t channels = png_get_channels(png_, info_);
    const std::size_t rowSamples = static_cast<std::size_t>(width) * channels;
    if (png_get_bit_depth(png_, info_) != 16 || (channels != 1 && channels != 3) ||
        png_get_rowbytes(png_, info_) != rowSamples * 2) {
      throw PngFailure{"has an unknown kind of pixels"};
    }
    MpcdiMap map;
    map.widthPx = static_cast<std::int32_t>(width);
    map.heightPx = static_cast<std::int32_t>(height);
    map.values.reserve(static_cast<std::size_t>(width * height));
    // Interlaced pictures must be held whole; others go row by row, so that memory follows what really comes.
    std::vector<std::uint16_t> rows(passes > 1 ? rowSamples * static_cast<std::size_t>(height) : rowSamples);
    for (int pass = 0; pass < passes; ++pass) {
      for (std::int64_t y = 0; y < height; ++y) {
        std::uint16_t* row = rows.data() + (passes > 1 ? static_cast<std::size_t>(y) * rowSamples : 0);
        png_read_row(png_, reinterpret_cast<png_bytep>(row), nullptr);
        if (pass + 1 == passes) append(map, row, channels);
      }
    }
    png_read_end(png_, nullptr);
    return map;
  }

 private:
  static void append(MpcdiMap& map, const std::uint16_t* row, std::size_t channels) {
    for (std::int32_t x = 0; x < map.widthPx; ++x, row += channels) {
      const std::uint32_t sum = channels == 1 ? row[0] : (std::uint32_t{row[0]} + row[1] + row[2] + 1) / 3;
      map.values.push_back(static_cast<std::uint16_t>(sum));
    }
  }

  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  PngSource source_;
};

}  // namespace

Result<MpcdiWarp> parsePfm(std::string_view bytes, const std::string& place) {
  const auto fail = [&](std::string what, std::string mend = {}) {
    return inputError(place, std::move(what), std::move(mend));
  };
  std::size_t at = 0;
  if (!bytes.starts_with("PF") || headerWord(bytes, at) != "PF") {
    return fail("is no portable float map of three channels", "it must begin with \"PF\"");
  }
  std::int64_t width = 0, height = 0;
  double scale = 0;
  if (!parseNumber(headerWord(bytes, at), width) || !parseNumber(headerWord(bytes, at), height)) {
    return fail("the header of the float map says no size");
  }
  if (const std::string fault = sizeFault(width, height); !fault.empty()) return fail(fault);
  if (!parseNumber(headerWord(bytes, at), scale) || !std::isfinite(scale) || scale == 0) {
    return fail("the header of the float map says no byte order");
  }
  const std::string_view data = bytes.substr(at);
  const std::int64_t wanted = width * height * 12;
  if (static_cast<std::int64_t>(data.size()) != wanted) {
    return fail("holds " + std::to_string(data.size()) + " bytes of samples; " + sizeText(width, height) +
                " need " + std::to_string(wanted));
  }
  MpcdiWarp warp;
  warp.columns = static_cast<std::int32_t>(width);
  warp.rows = static_cast<std::int32_t>(height);
  warp.xyz.resize(static_cast<std::size_t>(width * height * 3));
  const bool isSwapped = (scale < 0) != (std::endian::native == std::endian::little);
  const std::size_t rowFloats = static_cast<std::size_t>(width) * 3;
  for (std::int64_t row = 0; row < height; ++row) {
    const char* from = data.data() + static_cast<std::size_t>(height - 1 - row) * rowFloats * 4;
    float* to = warp.xyz.data() + static_cast<std::size_t>(row) * rowFloats;
    for (std::size_t i = 0; i < rowFloats; ++i) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, from + i * 4, 4);
      if (isSwapped) bits = __builtin_bswap32(bits);
      const float value = std::bit_cast<float>(bits);
      // Values without bounds would only make overflows later; nothing real is a million metres away.
      to[i] = std::abs(value) <= 1e6F ? value : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return warp;
}

Result<MpcdiMap> parsePngMap(std::string_view bytes, const std::string& place) {
  try {
    return PngReader().read(bytes);
  } catch (const PngFailure& failure) {
    return inputError(place, "is no usable PNG picture: " + failure.what);
  }
}

}  // namespace tessera

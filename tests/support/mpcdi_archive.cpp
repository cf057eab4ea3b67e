#include "tests/support/mpcdi_archive.h"

#include <bit>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <png.h>
#include <zip.h>

namespace tessera::test {

void writeArchive(const std::string& path, const std::map<std::string, std::string>& files) {
  int code = 0;
  zip_t* zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  if (!zip) std::abort();
  for (const auto& [name, bytes] : files) {
    zip_source_t* source = zip_source_buffer(zip, bytes.data(), bytes.size(), 0);
    if (!source || zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8) < 0) std::abort();
  }
  if (zip_close(zip) != 0) std::abort();
}

std::string pfm(int columns, int rows, const std::function<Sample(int, int)>& at, bool isLittleEndian) {
  std::string bytes = "PF\n" + std::to_string(columns) + ' ' + std::to_string(rows) +
                      (isLittleEndian ? "\n-1.0\n" : "\n1.0\n");
  const auto append = [&](float value) {
    auto bits = std::bit_cast<std::uint32_t>(value);
    if (isLittleEndian != (std::endian::native == std::endian::little)) bits = __builtin_bswap32(bits);
    char raw[4];
    std::memcpy(raw, &bits, 4);
    bytes.append(raw, 4);
  };
  for (int row = rows - 1; row >= 0; --row) {
    for (int column = 0; column < columns; ++column) {
      const Sample sample = at(column, row);
      append(sample.x);
      append(sample.y);
      append(sample.z);
    }
  }
  return bytes;
}

std::string png(int width, int height, int channels, int bits, bool isInterlaced,
                const std::function<std::uint16_t(int, int, int)>& at) {
  std::string bytes;
  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(writer);
  png_set_write_fn(
      writer, &bytes,
      [](png_structp p, png_bytep data, png_size_t count) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<const char*>(data), count);
      },
      nullptr);
  png_set_IHDR(writer, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits,
               channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
               isInterlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer, info);
  const std::size_t rowBytes = static_cast<std::size_t>(width * channels * bits / 8);
  std::vector<std::uint8_t> all(rowBytes * static_cast<std::size_t>(height));
  std::uint8_t* to = all.data();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int channel = 0; channel < channels; ++channel) {
        const std::uint16_t value = at(x, y, channel);
        *to++ = static_cast<std::uint8_t>(value >> 8);
        if (bits == 16) *to++ = static_cast<std::uint8_t>(value & 0xff);
      }
    }
  }
  std::vector<png_bytep> rows;
  for (int y = 0; y < height; ++y)
    rows.push_back(all.data() + static_cast<std::size_t>(y) * rowBytes);
  png_write_image(writer, rows.data());
  png_write_end(writer, nullptr);
  png_destroy_write_struct(&writer, &info);
  return bytes;
}

std::string twoRegions2d() {
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<MPCDI profile="2d" geometry="1" level="1" date="2026-01-01 00:00:00" version="1.0">
  <display>
    <buffer id="front" Xresolution="300" Yresolution="100">
      <region id="left" Xresolution="180" Yresolution="100" x="0" y="0" xsize="0.6" ysize="1"/>
      <region id="right" Xresolution="180" Yresolution="50" x="0.4" y="0.25" xsize="0.6" ysize="0.5"/>
    </buffer>
  </display>
  <files>
    <fileset region="left">
      <geometryWarpFile><path>left.pfm</path><interpolation>linear</interpolation></geometryWarpFile>
      <alphaMap><path>maps/left.png</path><componentDepth>1</componentDepth><bitDepth>8</bitDepth>
        <gammaEmbedded>2.2</gammaEmbedded></alphaMap>
      <betaMap><path>beta.png</path></betaMap>
    </fileset>
    <fileset region="right">
      <geometryWarpFile><path>right.pfm</path></geometryWarpFile>
      <alphaMap><path>right.png</path></alphaMap>
    </fileset>
  </files>
</MPCDI>
)";
}

}  // namespace tessera::test

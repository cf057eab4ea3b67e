#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace tessera::test {

/// A zip archive of these files.
void writeArchive(const std::string& path, const std::map<std::string, std::string>& files);

/// A float map of three channels; `at(column, row)` gives the values of a sample, row 0 at the picture's top.
struct Sample {
  float x, y, z;
};
std::string pfm(int columns, int rows, const std::function<Sample(int, int)>& at, bool isLittleEndian = true);

/// A PNG of grey (1 channel) or red, green and blue (3) with 8 or 16 bits; `at(x, y, channel)` as 16 bits.
std::string png(int width, int height, int channels, int bits, bool isInterlaced,
                const std::function<std::uint16_t(int, int, int)>& at);

/// A description with two blended projectors side by side on one buffer of 300 x 100 pixels, profile 2d.
std::string twoRegions2d();

}  // namespace tessera::test

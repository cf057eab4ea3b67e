#include "common/wall/wall_svg.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "common/wall/json_reader.h"

namespace tessera {

namespace {

constexpr double kWallSide = 1200;  // of the wall's longer side in the picture; other lengths suit it
constexpr double kMargin = 24;
constexpr double kLineHeight = 26;
constexpr double kFontSize = 18;
constexpr double kSmallestFontSize = 1.5;  // readable after zooming in, so worth drawing

/// Text as XML 1.0 can hold it: control characters and the two non-characters, which no reader accepts, are
/// shown as "?".
std::string escaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("\xEF\xBF\xBE") || rest.starts_with("\xEF\xBF\xBF")) {
      out += '?';
      i += 2;
      continue;
    }
    switch (text[i]) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&apos;";
        break;
      default:
        out += static_cast<unsigned char>(text[i]) < 0x20 ? '?' : text[i];
    }
  }
  return out;
}

/// Three decimals are enough for a picture and for people.
std::string shortText(double number) {
  return numberText(std::round(number * 1000) / 1000);
}

std::string attribute(std::string_view name, double value) {
  return std::string(" ").append(name) + "=\"" + shortText(value) + '"';
}

std::string textElement(double x, double y, double fontSize, std::string_view anchor, std::string_view text) {
  return "<text" + attribute("x", x) + attribute("y", y) + attribute("font-size", fontSize) +
         " text-anchor=\"" + std::string(anchor) + "\">" + escaped(text) + "</text>\n";
}

std::string pixelText(int widthPx, int heightPx) {
  return std::to_string(widthPx) + " x " + std::to_string(heightPx) + " px";
}

/// The largest size at which the text fits the width; letters are taken for 0.62 of their height wide.
double fittingFontSize(std::string_view text, double width, double height) {
  return std::min(height, width / (0.62 * static_cast<double>(std::max<std::size_t>(text.size(), 1))));
}

std::string tileElements(const Tile& tile, double scale) {
  const double x = kMargin + tile.xPx * scale;
  const double y = kMargin + tile.yPx * scale;
  const double width = tile.widthPx * scale;
  const double height = tile.heightPx * scale;
  const bool isDark = (tile.row + tile.column) % 2 != 0;
  std::string out = "<rect" + attribute("x", x) + attribute("y", y) + attribute("width", width) +
                    attribute("height", height) + " fill=\"" + (isDark ? "#dce8f2" : "#eef4f9") +
                    "\" stroke=\"#33658a\" vector-effect=\"non-scaling-stroke\"/>\n";
  const double nameSize = fittingFontSize(tile.name, 0.8 * width, std::min(0.3 * height, 2 * kFontSize));
  if (nameSize >= kSmallestFontSize) {
    out += textElement(x + width / 2, y + height / 2, nameSize, "middle", tile.name);
  }
  const std::string pixels = pixelText(tile.widthPx, tile.heightPx);
  const double pixelsSize = fittingFontSize(pixels, 0.8 * width, 0.6 * nameSize);
  if (pixelsSize >= kSmallestFontSize) {
    out += textElement(x + width / 2, y + height / 2 + 0.9 * nameSize, pixelsSize, "middle", pixels);
  }
  return out;
}

std::string clipText(std::string_view label, const std::optional<double>& distanceM) {
  const std::string text(label);
  return distanceM ? text + ' ' + numberText(*distanceM) + " m" : text + " fitted to the scene";
}

std::vector<std::string> captionOf(const Wall& wall) {
  constexpr double kDegPerRadian = 180 / std::numbers::pi;
  const double aspect = static_cast<double>(wall.widthPx()) / wall.heightPx();
  const double fovXRad = 2 * std::atan(std::tan(wall.fovYRad / 2) * aspect);
  std::vector<std::string> lines = {wall.name.empty() ? wall.source : wall.name,
                                    std::to_string(wall.columns) + " x " + std::to_string(wall.rows) +
                                        " tiles, " + pixelText(wall.widthPx(), wall.heightPx()) + " in all",
                                    "Field of view " + shortText(wall.fovYRad * kDegPerRadian) +
                                        " deg vertical, " + shortText(fovXRad * kDegPerRadian) +
                                        " deg horizontal",
                                    clipText("Near", wall.near) + ", " + clipText("far", wall.far)};
  for (const std::string& warning : wall.warnings)
    lines.push_back("Warning: " + warning);
  return lines;
}

}  // namespace

std::string wallSvg(const Wall& wall) {
  const double scale = kWallSide / std::max({wall.widthPx(), wall.heightPx(), 1});
  const std::vector<std::string> caption = captionOf(wall);
  // As wide as the widest line, since a tall wall may be narrower than its caption.
  double width = wall.widthPx() * scale;
  for (const std::string& line : caption) {
    width = std::max(width, 0.55 * kFontSize * static_cast<double>(line.size()));
  }
  const double captionY = 2 * kMargin + wall.heightPx() * scale;
  const double height = captionY + kLineHeight * static_cast<double>(caption.size()) + kMargin;

  const std::string box = "0 0 " + shortText(width + 2 * kMargin) + " " + shortText(height);
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"";
  out += attribute("width", width + 2 * kMargin) + attribute("height", height) + " viewBox=\"" + box + "\"";
  out += " font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" fill=\"#1b2a36\">\n";
  out += "<title>" + escaped("Wall " + caption.front()) + "</title>\n";
  out += "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  for (const Tile& tile : wall.tiles)
    out += tileElements(tile, scale);
  double y = captionY + kFontSize;
  for (const std::string& line : caption) {
    out += textElement(kMargin, y, kFontSize, "start", line);
    y += kLineHeight;
  }
  return out + "</svg>\n";
}

}  // namespace tessera

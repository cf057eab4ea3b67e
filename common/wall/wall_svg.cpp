#include "common/wall/wall_svg.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "common/wall/json_reader.h"
#include "common/wall/wall_picture.h"

namespace tessera {

namespace {

constexpr double kWallSide = 1200;  // of the wall's longer side in the picture; other lengths suit it
constexpr double kPlanSide = 520;   // of the view from above
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

std::string points(const std::vector<Vec2>& corners) {
  std::string text;
  for (const Vec2& p : corners)
    text += (text.empty() ? "" : " ") + shortText(p.x()) + "," + shortText(p.y());
  return text;
}

std::string polygon(const std::vector<Vec2>& corners, std::string_view style) {
  return "<polygon points=\"" + points(corners) + "\" " + std::string(style) +
         " vector-effect=\"non-scaling-stroke\"/>\n";
}

std::string circle(const Vec2& at, double radius, std::string_view style) {
  return "<circle" + attribute("cx", at.x()) + attribute("cy", at.y()) + attribute("r", radius) + " " +
         std::string(style) + "/>\n";
}

/// The wall from the front, laid out flat.
class FrontView {
 public:
  explicit FrontView(const Wall& wall)
      : wall_(wall),
        picture_(wallPicture(wall)),
        scale_(kWallSide / std::max(picture_.widthMm, picture_.heightMm)) {}

  [[nodiscard]] double width() const { return picture_.widthMm * scale_; }
  [[nodiscard]] double height() const { return picture_.heightMm * scale_; }

  [[nodiscard]] std::string elements() const {
    std::string out;
    for (std::size_t s = 0; s < wall_.screens.size(); ++s)
      out += screenElement(s);
    for (std::size_t t = 0; t < wall_.tiles.size(); ++t)
      out += tileElements(t);
    if (wall_.screens.size() == 1) return out;
    for (std::size_t s = 0; s < wall_.screens.size(); ++s) {
      const Screen& screen = wall_.screens[s];
      const Vec2 at = onPage(picture_.screens[s].at(Vec2(0, screen.heightMm / 2)));
      out += textElement(at.x(), at.y() + kFontSize, 0.8 * kFontSize, "middle", screen.name);
    }
    return out;
  }

 private:
  [[nodiscard]] Vec2 onPage(const Vec2& mm) const { return mm * scale_ + Vec2(kMargin, kMargin); }

  [[nodiscard]] std::string screenElement(std::size_t s) const {
    const double w = wall_.screens[s].widthMm / 2, h = wall_.screens[s].heightMm / 2;
    std::vector<Vec2> corners;
    for (const Vec2& mm : {Vec2(-w, -h), Vec2(w, -h), Vec2(w, h), Vec2(-w, h)})
      corners.push_back(onPage(picture_.screens[s].at(mm)));
    return polygon(corners, "fill=\"#c9ccd1\" stroke=\"none\"");
  }

  [[nodiscard]] std::string tileElements(std::size_t t) const {
    const Tile& tile = wall_.tiles[t];
    const PicturePlace& place = picture_.tiles[t];
    const auto at = [&](double x, double y) {  // of the tile's pixels
      const Vec2 px = place.corner + place.across * x + place.down * y;
      return onPage(Vec2(px.x() / picture_.pxPerMmAcross, px.y() / picture_.pxPerMmDown));
    };
    const double w = tile.widthPx, h = tile.heightPx;
    const bool overlaps = picture_.gamma > 0;
    std::string out = polygon({at(0, 0), at(w, 0), at(w, h), at(0, h)},
                              std::string("class=\"tile\" fill=\"") + (t % 2 != 0 ? "#dce8f2" : "#eef4f9") +
                                  "\" fill-opacity=\"" + (overlaps ? "0.6" : "1") + "\" stroke=\"#33658a\"");
    if (tile.quarterTurns != 0 || tile.freeTurnRad != 0) {
      const double d = 0.12 * std::min(w, h);
      out += polygon({at(w / 2, d / 4), at(w / 2 + d / 2, d), at(w / 2 - d / 2, d)},
                     "fill=\"#33658a\" stroke=\"none\"");
    }
    Vec2 least = at(0, 0), most = least;
    for (const Vec2& corner : {at(w, 0), at(w, h), at(0, h)}) {
      least = least.cwiseMin(corner);
      most = most.cwiseMax(corner);
    }
    const Vec2 middle = (least + most) / 2, size = most - least;
    const double nameSize =
        fittingFontSize(tile.name, 0.8 * size.x(), std::min(0.3 * size.y(), 2 * kFontSize));
    double y = middle.y();
    const auto line = [&](const std::string& text, double largest) {
      const double fontSize = fittingFontSize(text, 0.8 * size.x(), largest);
      if (text.empty() || fontSize < kSmallestFontSize) return;
      out += textElement(middle.x(), y, fontSize, "middle", text);
      y += 0.9 * nameSize;
    };
    line(tile.name, nameSize);
    line(pixelText(tile.widthPx, tile.heightPx), 0.6 * nameSize);
    line(tile.output.host, 0.6 * nameSize);
    return out;
  }

  const Wall& wall_;
  const WallPicture picture_;
  const double scale_;
};

/// The wall from above, with the eye and the tiles' frusta: x to the right, the view upwards. Of a virtual
/// camera the wall is drawn one metre wide.
class PlanView {
 public:
  explicit PlanView(const Wall& wall) : wall_(wall) {
    if (wall.observer) {
      eye_ = above(wall.observer->eyeM);
    } else {
      const Screen& screen = wall.screens.front();
      const double perMm = 1 / screen.widthMm;
      const double distance = screen.heightMm * perMm / 2 / std::tan(wall.fovYRad / 2);
      for (const auto& [index, corners] : drawn()) {
        for (const Vec2& corner : corners)
          ends_.emplace_back(corner.x() / 2, -distance);
      }
    }
    for (const auto& [index, corners] : drawn()) {
      if (!wall.observer) break;
      const Screen& screen = wall.screens[index];
      for (const Vec2& corner : corners) {
        ends_.push_back(above(screen.centerM + screen.right * (corner.x() * screen.widthMm / 2000) +
                              screen.up * (corner.y() * screen.heightMm / 2000)));
      }
    }
    least_ = most_ = eye_;
    for (const Vec2& end : ends_) {
      least_ = least_.cwiseMin(end);
      most_ = most_.cwiseMax(end);
    }
    scale_ = kPlanSide / std::max({most_.x() - least_.x(), most_.y() - least_.y(), 1e-9});
  }

  [[nodiscard]] double width() const { return (most_.x() - least_.x()) * scale_; }
  [[nodiscard]] double height() const { return (most_.y() - least_.y()) * scale_; }

  [[nodiscard]] std::string elements(double top) const {
    const auto onPage = [&](const Vec2& m) {
      const Vec2 p = (m - least_) * scale_;
      return Vec2(p.x() + kMargin, p.y() + top);
    };
    std::string out;
    for (std::size_t t = 0; 4 * t < ends_.size(); ++t) {
      const Vec2 eye = onPage(eye_);
      std::vector<Vec2> corners;
      for (std::size_t i = 0; i < 4; ++i)
        corners.push_back(onPage(ends_[4 * t + i]));
      for (std::size_t i = 0; i < 4; ++i)
        out += polygon({eye, corners[i], corners[(i + 1) % 4]},
                       "fill=\"#33658a\" fill-opacity=\"0.05\" stroke=\"#33658a\" stroke-opacity=\"0.35\"");
      out += polygon(corners, "fill=\"#1b2a36\" fill-opacity=\"0.15\" stroke=\"#1b2a36\" stroke-width=\"2\"");
    }
    return out + circle(onPage(eye_), 5, "fill=\"#b3261e\"");
  }

 private:
  /// Tiles, by their screens; of large walls the whole screens.
  [[nodiscard]] std::vector<std::pair<std::uint32_t, std::array<Vec2, 4>>> drawn() const {
    constexpr std::size_t kMostTiles = 64;
    std::vector<std::pair<std::uint32_t, std::array<Vec2, 4>>> all;
    if (wall_.tiles.size() > kMostTiles) {
      for (std::uint32_t s = 0; s < wall_.screens.size(); ++s)
        all.emplace_back(s, Tile().corners);
      return all;
    }
    for (const Tile& tile : wall_.tiles)
      all.emplace_back(tile.screen, tile.corners);
    return all;
  }
  static Vec2 above(const Vec3& m) { return {m.x(), m.z()}; }

  const Wall& wall_;
  Vec2 eye_ = Vec2::Zero(), least_, most_;
  std::vector<Vec2> ends_;  ///< four for each tile
  double scale_ = 1;
};

std::string clipText(std::string_view label, const std::optional<double>& distanceM) {
  const std::string text(label);
  return distanceM ? text + ' ' + numberText(*distanceM) + " m" : text + " fitted to the scene";
}

std::string eyeText(const Wall& wall) {
  constexpr double kDegPerRadian = 180 / std::numbers::pi;
  if (wall.observer) {
    const Vec3& eye = wall.observer->eyeM;
    constexpr std::array kStereo = {"", ", stereo side by side", ", stereo top and bottom",
                                    ", an eye for each tile", ", stereo by quad buffers"};
    return "Eye at " + shortText(eye.x()) + ", " + shortText(eye.y()) + ", " + shortText(eye.z()) + " m" +
           kStereo[static_cast<std::size_t>(wall.observer->stereo)] +
           (wall.observer->oscPort > 0
                ? ", tracked over OSC at port " + std::to_string(wall.observer->oscPort)
                : "");
  }
  const Screen& screen = wall.screens.front();
  const double fovXRad = 2 * std::atan(std::tan(wall.fovYRad / 2) * screen.widthMm / screen.heightMm);
  return "Field of view " + shortText(wall.fovYRad * kDegPerRadian) + " deg vertical, " +
         shortText(fovXRad * kDegPerRadian) + " deg horizontal";
}

std::vector<std::string> captionOf(const Wall& wall) {
  std::vector<std::string> lines = {wall.name.empty() ? wall.source : wall.name, summaryOf(wall),
                                    eyeText(wall),
                                    clipText("Near", wall.near) + ", " + clipText("far", wall.far)};
  for (const std::string& warning : wall.warnings)
    lines.push_back("Warning: " + warning);
  return lines;
}

}  // namespace

std::string wallSvg(const Wall& wall) {
  const FrontView front(wall);
  const PlanView plan(wall);
  const std::vector<std::string> caption = captionOf(wall);
  // As wide as the widest line, since a tall wall may be narrower than its caption.
  double width = std::max(front.width(), plan.width());
  for (const std::string& line : caption)
    width = std::max(width, 0.55 * kFontSize * static_cast<double>(line.size()));
  const double captionY = 2 * kMargin + front.height();
  const double planY = captionY + kLineHeight * static_cast<double>(caption.size()) + 2 * kMargin;
  const double height = planY + plan.height() + kLineHeight + kMargin;

  const std::string box = "0 0 " + shortText(width + 2 * kMargin) + " " + shortText(height);
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"";
  out += attribute("width", width + 2 * kMargin) + attribute("height", height) + " viewBox=\"" + box + "\"";
  out += " font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" fill=\"#1b2a36\">\n";
  out += "<title>" + escaped("Wall " + caption.front()) + "</title>\n";
  out += "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  out += front.elements();
  double y = captionY + kFontSize;
  for (const std::string& line : caption) {
    out += textElement(kMargin, y, kFontSize, "start", line);
    y += kLineHeight;
  }
  out += plan.elements(planY);
  out += textElement(kMargin, planY + plan.height() + kLineHeight, 0.8 * kFontSize, "start",
                     "From above: the eye and the tiles' frusta");
  return out + "</svg>\n";
}

}  // namespace tessera

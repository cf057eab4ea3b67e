#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "common/wall/import/equalizer_tree.h"
#include "common/wall/import/formats.h"
#include "common/wall/import/wall_text.h"
#include "common/wall/import/warning_list.h"

namespace tessera {

namespace {

using Kind = EqualizerNode::Kind;

constexpr double kPipeWidthPx = 1920, kPipeHeightPx = 1080;
constexpr double kEyeBaseM = 0.05;  // Equalizer's own where a file says nothing

const char* const kLeftOut = "not a part of a wall; left out";

/// A rectangle: pixels of a window or parts of a whole.
struct Rect {
  double x = 0, y = 0, width = 1, height = 1;
  [[nodiscard]] bool isWhole() const { return x == 0 && y == 0 && width == 1 && height == 1; }
};

/// Where a channel's picture stands on the desktop of its pipe, pixels, y down.
struct Channel {
  Rect px;
  bool hasWindowPosition = false;
  std::string host;
  int line = 0;
  bool isUsed = false;
};

struct Frustum {
  walltext::Corners corners;
  int line = 0;
};

class Importer {
 public:
  explicit Importer(std::string fileName) : fileName_(std::move(fileName)) {}

  Result<ImportedWall> run(const EqualizerNode& root) {
    const EqualizerNode* config = findConfig(root);
    if (!config) {
      fail(0, "has no config block, so describes no wall");
    } else {
      settings(*config);
      resources(*config);
      layouts(*config);
      for (const EqualizerNode& child : config->children) {
        if (child.key == "canvas") canvas(child);
      }
      others(*config);
    }
    if (!error_ && wall_.screens.empty()) {
      fail(config->line, "has no canvas with segments, so it does not say where its channels stand",
           "describe the wall with a canvas");
    }
    if (error_) return *error_;
    for (const auto& [name, channel] : channels_) {
      if (!channel.isUsed) {
        warnings_.add("channel that no segment of a canvas shows", channel.line, "helps to draw; left out");
      }
    }
    finishStereo();
    settleEyes(wall_, warnings_);
    wall_.name = wallNameOf(fileName_);
    wall_.origin = "From the Equalizer configuration " + std::filesystem::path(fileName_).filename().string();
    Result<std::string> json = wallText(wall_, fileName_);
    if (!json) return json.error();
    return ImportedWall{std::move(*json), warnings_.texts(fileName_)};
  }

 private:
  void fail(int line, std::string what, std::string mend = {}) {
    if (error_) return;
    error_ = inputError(line > 0 ? fileName_ + ':' + std::to_string(line) : fileName_, std::move(what),
                        std::move(mend));
  }

  const EqualizerNode* findConfig(const EqualizerNode& root) {
    const EqualizerNode* config = nullptr;
    const auto look = [&](const EqualizerNode& node) {
      if (node.key == "config" && node.kind == Kind::Block) {
        if (config) {
          warnings_.add("further config", node.line, "only the first is read; left out");
        } else {
          config = &node;
        }
        return;
      }
      if (node.key == "global") {
        global(node);
      } else if (node.key == "connection") {
        warnings_.add("connection of the server", node.line, kLeftOut);
      } else {
        warnings_.add(node.key, node.line, kLeftOut);
      }
    };
    for (const EqualizerNode& node : root.children) {
      if (node.key != "server" || node.kind != Kind::Block) {
        look(node);
        continue;
      }
      for (const EqualizerNode& child : node.children)
        look(child);
    }
    return config;
  }

  void global(const EqualizerNode& node) {
    for (const EqualizerNode& child : node.children) {
      if (child.key == "EQ_CONFIG_FATTR_EYE_BASE" && child.kind == Kind::Number) {
        eyeBaseM_ = child.number;
      } else if (child.key == "EQ_WINDOW_IATTR_HINT_FULLSCREEN") {
        isFullscreen_ = child.text == "ON";
      } else {
        warnings_.add("global attribute", child.line, kLeftOut);
      }
    }
  }

  void settings(const EqualizerNode& config) {
    for (const EqualizerNode& child : config.children) {
      if (child.key != "attributes") continue;
      for (const EqualizerNode& attribute : child.children) {
        if (attribute.key == "eye_base" && attribute.kind == Kind::Number) {
          eyeBaseM_ = attribute.number;
        } else {
          warnings_.add("attribute of the config", attribute.line, kLeftOut);
        }
      }
    }
  }

  // Resources: nodes, pipes, windows and channels.

  void resources(const EqualizerNode& config) {
    for (const EqualizerNode& node : config.children) {
      if (node.key != "appNode" && node.key != "node") continue;
      std::string host;
      for (const EqualizerNode& child : node.children) {
        if (child.key == "host") {
          host = child.text;
        } else if (child.key == "connection") {
          for (const EqualizerNode& field : child.children) {
            if (field.key == "hostname") {
              host = field.text;
            } else {
              warnings_.add(field.key + " of a connection", field.line, kLeftOut);
            }
          }
        }
      }
      for (const EqualizerNode& child : node.children) {
        if (child.key == "pipe") {
          pipe(child, host);
        } else if (child.key != "host" && child.key != "connection" && child.key != "name") {
          warnings_.add(child.key + " of a node", child.line, kLeftOut);
        }
      }
    }
  }

  void pipe(const EqualizerNode& pipe, const std::string& host) {
    std::optional<Rect> pipePx;
    if (const EqualizerNode* viewport = pipe.find("viewport")) {
      const Rect px = rect(*viewport);
      if (px.width > 1 || px.height > 1) pipePx = Rect{0, 0, px.width, px.height};
    }
    for (const EqualizerNode& child : pipe.children) {
      if (child.key == "window") {
        window(child, pipePx, host);
      } else if (child.key == "device" || child.key == "port") {
        warnings_.add(
            child.key + " of a pipe", child.line,
            "which display a tile's program opens its window on is not said in a wall file; left out");
      } else if (child.key != "viewport" && child.key != "name") {
        warnings_.add(child.key + " of a pipe", child.line, kLeftOut);
      }
    }
  }

  void window(const EqualizerNode& window, const std::optional<Rect>& pipePx, const std::string& host) {
    bool isFullscreen = isFullscreen_;
    for (const EqualizerNode& child : window.children) {
      if (child.key == "attributes") {
        for (const EqualizerNode& attribute : child.children) {
          if (attribute.key == "hint_fullscreen") {
            isFullscreen = attribute.text == "ON";
          } else {
            warnings_.add("attribute of a window", attribute.line, kLeftOut);
          }
        }
      } else if (child.key != "viewport" && child.key != "name" && child.key != "channel") {
        warnings_.add(child.key + " of a window", child.line, kLeftOut);
      }
    }
    const EqualizerNode* viewport = window.find("viewport");
    const Rect part = viewport && !isFullscreen ? rect(*viewport) : Rect{};
    const bool isPixels = part.width > 1 || part.height > 1;
    const Rect whole = pipePx.value_or(Rect{0, 0, kPipeWidthPx, kPipeHeightPx});
    const Rect px = isPixels
                        ? part
                        : Rect{std::round(part.x * whole.width), std::round(part.y * whole.height),
                               std::round(part.width * whole.width), std::round(part.height * whole.height)};
    for (const EqualizerNode& child : window.children) {
      if (child.key == "channel") channel(child, px, viewport && !isFullscreen, host, !isPixels && !pipePx);
    }
  }

  void channel(const EqualizerNode& node, const Rect& windowPx, bool hasPosition, const std::string& host,
               bool isAssumed) {
    const EqualizerNode* name = node.find("name");
    const EqualizerNode* viewport = node.find("viewport");
    for (const EqualizerNode& child : node.children) {
      if (child.key != "name" && child.key != "viewport") {
        warnings_.add(child.key + " of a channel", child.line, kLeftOut);
      }
    }
    const Rect part = viewport ? rect(*viewport) : Rect{};
    const bool isPixels = part.width > 1 || part.height > 1;
    const double scaleX = isPixels ? 1 : windowPx.width, scaleY = isPixels ? 1 : windowPx.height;
    Channel channel;
    // Edges are rounded, not sizes, so that neighbours meet. A channel's y counts from the window's bottom.
    const double left = std::round(part.x * scaleX), right = std::round((part.x + part.width) * scaleX);
    const double bottom = std::round(part.y * scaleY), top = std::round((part.y + part.height) * scaleY);
    channel.px = {windowPx.x + left, windowPx.y + windowPx.height - top, right - left, top - bottom};
    channel.hasWindowPosition = hasPosition || viewport;
    channel.host = host;
    channel.line = node.line;
    const std::string key = name ? name->text : "";
    if (!channels_.emplace(key, channel).second) {
      warnings_.add("channel with the name of another", node.line, "only the first is used; left out");
    }
    if (isAssumed) assumedChannels_.emplace(key, node.line);
  }

  // Layouts only divide the picture; observers say where the eyes are.

  void layouts(const EqualizerNode& config) {
    const EqualizerNode* observer = nullptr;
    for (const EqualizerNode& child : config.children) {
      if (child.key == "observer") {
        if (observer) {
          warnings_.add("further observer", child.line, "a wall has one eye; left out");
        } else {
          observer = &child;
        }
      }
      if (child.key != "layout") continue;
      for (const EqualizerNode& view : child.children) {
        if (view.key == "view") {
          this->view(view);
        } else if (view.key != "name") {
          warnings_.add(view.key + " of a layout", view.line, kLeftOut);
        }
      }
    }
    Vec3 left(-eyeBaseM_ / 2, 0, 0), right(eyeBaseM_ / 2, 0, 0), middle = Vec3::Zero();
    if (observer) {
      bool hasEyes = false, hasMiddle = false;
      for (const EqualizerNode& child : observer->children) {
        if (child.key == "eye_left") {
          left = point(child);
          hasEyes = true;
        } else if (child.key == "eye_right") {
          right = point(child);
          hasEyes = true;
        } else if (child.key == "eye_cyclop") {
          middle = point(child);
          hasMiddle = true;
        } else if (child.key == "eye_base" && child.kind == Kind::Number) {
          left = Vec3(-child.number / 2, 0, 0);
          right = Vec3(child.number / 2, 0, 0);
        } else if (child.key != "name") {
          warnings_.add(child.key + " of an observer", child.line,
                        "trackers say the eye to Tessera by OSC (\"osc_port\"); left out");
        }
      }
      if (hasEyes && !hasMiddle) middle = (left + right) / 2;
    }
    walltext::Observer eyes;
    eyes.eyeM = middle;
    eyes.separationMm = lengthOf(right - left) * 1000;
    wall_.observer = eyes;
  }

  void view(const EqualizerNode& view) {
    for (const EqualizerNode& child : view.children) {
      if (child.key == "mode") {
        isStereo_ = isStereo_ || child.text == "STEREO";
      } else if (child.key == "wall" || child.key == "projection") {
        warnings_.add(child.key + " of a view", child.line,
                      "says what a part of the picture shows, not where a screen stands; left out");
      } else if (child.key == "viewport") {
        if (!rect(child).isWhole()) {
          warnings_.add("viewport of a view", child.line, "a wall shows one picture; left out");
        }
      } else if (child.key == "attributes") {
        for (const EqualizerNode& attribute : child.children)
          warnings_.add("attribute of a view (" + attribute.key.substr(0, 64) + ")", attribute.line,
                        kLeftOut);
      } else if (child.key != "name" && child.key != "observer") {
        warnings_.add(child.key + " of a view", child.line, kLeftOut);
      }
    }
  }

  // Canvases are the walls.

  void canvas(const EqualizerNode& canvas) {
    const std::optional<Frustum> whole = frustum(canvas);
    int layoutCount = 0;
    walltext::Screen shared;
    if (whole) shared.corners = whole->corners;
    const EqualizerNode* name = canvas.find("name");
    std::vector<walltext::Screen> own;
    for (const EqualizerNode& child : canvas.children) {
      if (child.key == "segment") {
        segment(child, shared, own);
      } else if (child.key == "layout") {
        if (++layoutCount > 1) {
          warnings_.add("further layout of a canvas", child.line,
                        "layouts divide the picture, a wall shows one; left out");
        }
      } else if (child.key != "wall" && child.key != "projection" && child.key != "name") {
        warnings_.add(child.key + " of a canvas", child.line, kLeftOut);
      }
    }
    if (!shared.tiles.empty()) {
      shared.name = screenNames_.make(name ? name->text : "canvas");
      wall_.screens.push_back(std::move(shared));
    }
    for (walltext::Screen& screen : own)
      wall_.screens.push_back(std::move(screen));
  }

  void segment(const EqualizerNode& segment, walltext::Screen& shared, std::vector<walltext::Screen>& own) {
    const EqualizerNode* channelName = segment.find("channel");
    const std::optional<Frustum> frustumOfItsOwn = frustum(segment);
    bool isLeft = false, isRight = false, isMiddle = false, hasEye = false;
    Rect part;
    for (const EqualizerNode& child : segment.children) {
      if (child.key == "viewport") {
        part = rect(child);
      } else if (child.key == "eye") {
        hasEye = true;
        const auto has = [&](std::string_view eye) {
          return child.text == eye ||
                 std::find(child.words.begin(), child.words.end(), eye) != child.words.end();
        };
        isLeft = has("LEFT");
        isRight = has("RIGHT");
        isMiddle = has("CYCLOP");
      } else if (child.key != "channel" && child.key != "wall" && child.key != "projection" &&
                 child.key != "name") {
        warnings_.add(child.key + " of a segment", child.line, kLeftOut);
      }
    }
    if (error_) return;
    if (!channelName) {
      fail(segment.line, "the segment shows no channel", "name one: channel \"...\"");
      return;
    }
    const auto found = channels_.find(channelName->text);
    if (found == channels_.end()) {
      fail(channelName->line, "no window has a channel named \"" + channelName->text.substr(0, 64) + '"');
      return;
    }
    Channel& channel = found->second;
    channel.isUsed = true;
    if (hasEye && isStereo_ && !isLeft && !isRight) {
      warnings_.add("segment for the middle eye", segment.line, "stereo shows the other segments; left out");
      return;
    }
    if (hasEye && !isStereo_ && !isMiddle) {
      warnings_.add("segment for single eyes", segment.line, "no view is in stereo mode; left out");
      return;
    }
    if (const auto assumed = assumedChannels_.find(channelName->text); assumed != assumedChannels_.end()) {
      warnings_.add("channel without a size in pixels", assumed->second,
                    "its display is taken to have 1920 x 1080 pixels");
    }
    walltext::Tile tile;
    const EqualizerNode* name = segment.find("name");
    tile.name = tileNames_.make(name ? name->text : channelName->text);
    tile.px = {pixels(channel.px.width, channel.line), pixels(channel.px.height, channel.line)};
    tile.settings.host = channel.host;
    if (channel.hasWindowPosition) {
      tile.settings.windowPx = {pixels(channel.px.x, channel.line), pixels(channel.px.y, channel.line)};
    }
    if (hasEye && isStereo_ && isLeft != isRight) {
      tile.settings.eye = isLeft ? walltext::Eye::Left : walltext::Eye::Right;
      hasEyeTiles_ = true;
    }
    if (frustumOfItsOwn) {
      walltext::Screen screen;
      screen.name = screenNames_.make(tile.name);
      screen.corners = frustumOfItsOwn->corners;
      tile.sizeMm = sizeMm(*screen.corners);
      screen.tiles.push_back(std::move(tile));
      own.push_back(std::move(screen));
    } else if (shared.corners) {
      const std::array<double, 2> size = sizeMm(*shared.corners);
      tile.sizeMm = {part.width * size[0], part.height * size[1]};
      tile.atMm = {part.x * size[0], (1 - part.y - part.height) * size[1]};
      shared.tiles.push_back(std::move(tile));
    } else {
      fail(segment.line,
           "neither the segment nor its canvas says with a wall or a projection where it stands",
           "add a wall");
    }
  }

  /// Of a canvas or segment, with the surface where its picture is seen from the observer's eye.
  std::optional<Frustum> frustum(const EqualizerNode& node) {
    std::optional<Frustum> found;
    for (const EqualizerNode& child : node.children) {
      if (child.key == "wall") found = Frustum{wall(child), child.line};
      if (child.key == "projection") found = Frustum{projection(child), child.line};
    }
    if (!found || error_) return std::nullopt;
    walltext::Corners& corners = found->corners;
    const Vec3 right = corners.lowerRight - corners.lowerLeft, up = corners.upperLeft - corners.lowerLeft;
    const Vec3 eye = wall_.observer ? wall_.observer->eyeM : Vec3::Zero();
    if (lengthOf(up) > 0 && (eye - corners.lowerLeft).dot(right.cross(up)) < 0) {
      // Equalizer draws a surface that faces away from the eye as if it were turned half around the eye.
      const Vec3 axis = up / lengthOf(up);
      const auto turned = [&](const Vec3& p) -> Vec3 {
        return eye + 2 * axis * axis.dot(p - eye) - (p - eye);
      };
      corners = {turned(corners.lowerRight), turned(corners.lowerLeft), turned(corners.lowerRight + up)};
      warnings_.add("surface that faces away from the eye", found->line,
                    "turned half around the eye, as Equalizer draws it");
    }
    return found;
  }

  walltext::Corners wall(const EqualizerNode& wall) {
    // Equalizer's own wall, of which a block may change single corners.
    walltext::Corners corners{Vec3(-0.8, -0.5, -1), Vec3(0.8, -0.5, -1), Vec3(-0.8, 0.5, -1)};
    for (const EqualizerNode& child : wall.children) {
      if (child.key == "bottom_left") {
        corners.lowerLeft = point(child);
      } else if (child.key == "bottom_right") {
        corners.lowerRight = point(child);
      } else if (child.key == "top_left") {
        corners.upperLeft = point(child);
      } else if (child.key == "type") {
        if (child.text == "HMD") {
          warnings_.add(
              "wall of the type HMD", child.line,
              "moves with the head, which a wall file cannot say; imported as if the head stood still");
        } else if (child.text != "fixed") {
          warnings_.add("wall of an unknown type", child.line, "taken for a fixed one");
        }
      } else {
        warnings_.add(child.key + " of a wall", child.line, kLeftOut);
      }
    }
    return corners;
  }

  /// A projector at `origin`: its surface is `distance` along the z axis, turned by heading, pitch and roll,
  /// and as large as the fields of view make it there.
  walltext::Corners projection(const EqualizerNode& projection) {
    Vec3 origin = Vec3::Zero(), turn = Vec3::Zero();
    double distance = 0;
    std::array<double, 2> fovDeg = {0, 0};
    for (const EqualizerNode& child : projection.children) {
      if (child.key == "origin") {
        origin = point(child);
      } else if (child.key == "hpr") {
        turn = point(child);
      } else if (child.key == "distance" && child.kind == Kind::Number) {
        distance = child.number;
      } else if (child.key == "fov" && child.numbers.size() == 2) {
        fovDeg = {child.numbers[0], child.numbers[1]};
      } else {
        warnings_.add(child.key + " of a projection", child.line, kLeftOut);
      }
    }
    const auto isFov = [](double deg) { return std::abs(deg) > 0 && std::abs(deg) < 180; };
    if (!isFov(fovDeg[0]) || !isFov(fovDeg[1]) || distance == 0) {
      fail(projection.line, "the projection needs a distance and a fov of two angles below 180 degrees",
           "add \"distance\" and \"fov [ H V ]\"");
      return {};
    }
    constexpr double kRadians = std::numbers::pi / 180;
    const double width = std::abs(2 * distance * std::tan(fovDeg[0] / 2 * kRadians));
    const double height = std::abs(2 * distance * std::tan(fovDeg[1] / 2 * kRadians));
    const double cosH = std::cos(turn.x() * kRadians), sinH = std::sin(turn.x() * kRadians);
    const double cosP = std::cos(turn.y() * kRadians), sinP = std::sin(turn.y() * kRadians);
    const double cosR = std::cos(turn.z() * kRadians), sinR = std::sin(turn.z() * kRadians);
    // The axes of the surface: right, up, and from the projector to it.
    const Vec3 u(cosH * cosR, -cosH * sinR, -sinH);
    const Vec3 v(cosP * sinR - sinP * sinH * cosR, cosP * cosR + sinP * sinH * sinR, -sinP * cosH);
    const Vec3 w(cosP * sinH * cosR + sinP * sinR, sinP * cosR - cosP * sinH * sinR, cosP * cosH);
    const Vec3 middle = origin + w * distance;
    return {middle - u * (width / 2) - v * (height / 2), middle + u * (width / 2) - v * (height / 2),
            middle - u * (width / 2) + v * (height / 2)};
  }

  // All the rest is named in warnings.

  void others(const EqualizerNode& config) {
    for (const EqualizerNode& child : config.children) {
      const auto isOneOf = [&](std::initializer_list<std::string_view> keys) {
        return std::find(keys.begin(), keys.end(), child.key) != keys.end();
      };
      if (isOneOf({"appNode", "node", "observer", "layout", "canvas", "attributes", "name"})) continue;
      if (child.kind == Kind::Block) {
        drawing(child);
      } else {
        warnings_.add(child.key + " of the config", child.line, kLeftOut);
      }
    }
  }

  /// Compounds and what is in them: how Equalizer divides the work of drawing.
  void drawing(const EqualizerNode& node) {
    const std::string kind =
        node.key == "wall" || node.key == "projection" ? node.key + " of a compound" : node.key;
    warnings_.add(kind.substr(0, 64), node.line, "Tessera divides the work of drawing by itself; left out");
    for (const EqualizerNode& child : node.children) {
      if (child.kind == Kind::Block) drawing(child);
    }
  }

  void finishStereo() {
    if (hasEyeTiles_) {
      wall_.observer->stereo = walltext::Stereo::Tiles;
    } else if (isStereo_) {
      wall_.observer->stereo = walltext::Stereo::QuadBuffer;
      warnings_.add("stereo view without a segment for each eye", 0,
                    "taken for quad-buffered stereo; anaglyphs are not known");
    }
  }

  // Values.

  Rect rect(const EqualizerNode& node) {
    if (node.numbers.size() != 4 || !node.words.empty()) {
      fail(node.line, '"' + node.key + "\" must be a list of 4 numbers: [ X Y WIDTH HEIGHT ]");
      return {};
    }
    for (const double number : node.numbers) {
      if (std::abs(number) > 1e6) fail(node.line, '"' + node.key + "\" holds a number beyond 1000000");
    }
    return {node.numbers[0], node.numbers[1], node.numbers[2], node.numbers[3]};
  }

  Vec3 point(const EqualizerNode& node) {
    if (node.numbers.size() != 3 || !node.words.empty()) {
      fail(node.line, '"' + node.key + "\" must be a list of 3 numbers");
      return Vec3::Zero();
    }
    return {node.numbers[0], node.numbers[1], node.numbers[2]};
  }

  int pixels(double value, int line) {
    if (!(std::abs(value) <= 1e6)) {
      fail(line, "a window is further than a million pixels away");
      return 0;
    }
    return static_cast<int>(std::lround(value));
  }

  static std::array<double, 2> sizeMm(const walltext::Corners& corners) {
    return {lengthOf(corners.lowerRight - corners.lowerLeft) * 1000,
            lengthOf(corners.upperLeft - corners.lowerLeft) * 1000};
  }

  std::string fileName_;
  std::optional<Error> error_;
  WarningList warnings_;
  double eyeBaseM_ = kEyeBaseM;
  bool isFullscreen_ = false, isStereo_ = false, hasEyeTiles_ = false;
  std::map<std::string, Channel> channels_;
  std::map<std::string, int> assumedChannels_;  ///< and their lines
  NameMaker tileNames_, screenNames_;
  walltext::Wall wall_;
};

}  // namespace

Result<ImportedWall> importEqualizer(std::string_view text, const std::string& fileName) {
  const Result<EqualizerNode> root = parseEqualizer(text, fileName);
  if (!root) return root.error();
  return Importer(fileName).run(*root);
}

}  // namespace tessera

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "common/wall/import/formats.h"
#include "common/wall/import/wall_text.h"
#include "common/wall/json_reader.h"

namespace tessera {

namespace {

const char* const kLeftOut = "not a part of a wall; left out";
constexpr NumberRange kMetres = {-1e6, 1e6};
constexpr NumberRange kDegrees = {-360, 360};
constexpr NumberRange kHalfField = {-89.99, 89.99};
constexpr double kRadians = std::numbers::pi / 180;
constexpr double kPlanarDistanceM = 10;  // SGCT's own where a file says none

struct Part {
  double x = 0, y = 0, width = 1, height = 1;
};

struct Window {
  std::array<int, 2> sizePx = {0, 0};
  std::optional<std::array<int, 2>> positionPx;
  std::string host;
};

class Importer {
 public:
  explicit Importer(const std::string& fileName) : json_(fileName), fileName_(fileName) {}

  Result<ImportedWall> run(const JsonValue& root) {
    wall_.observer = walltext::Observer{};
    for (const JsonValue& child : root.children()) {
      if (child.key() == "users") users(child);
    }
    for (const JsonValue& child : root.children()) {
      if (child.key() == "nodes") {
        if (!json_.array(child, "nodes")) break;
        for (const JsonValue& node : child.children())
          this->node(node);
      } else if (child.key() != "users" && child.key() != "version") {
        warnings_.add(excerpt(child.key(), 64), child.keyLine(), kLeftOut);
      }
    }
    if (json_.ok() && wall_.screens.empty()) {
      json_.fail(curvedLine_ > 0 ? curvedLine_ : root.line(),
                 curvedLine_ > 0 ? "the pictures have the projection \"" + curved_ +
                                       "\", which shows no flat screen, so the file describes no wall"
                                 : "the file has no window with a viewport",
                 "only viewports with a ProjectionPlane or a PlanarProjection are flat screens");
    }
    if (!json_.ok()) return *json_.error();
    finishStereo();
    settleEyes(wall_, warnings_);
    wall_.name = wallNameOf(fileName_);
    wall_.origin = "From the SGCT configuration " + std::filesystem::path(fileName_).filename().string();
    Result<std::string> json = wallText(wall_, fileName_);
    if (!json) return json.error();
    return ImportedWall{std::move(*json), warnings_.texts(fileName_)};
  }

 private:
  bool isObject(const JsonValue& value, std::string_view label) {
    if (value.kind() == JsonKind::Object) return true;
    json_.fail(value.line(), '"' + std::string(label) + "\" must be an object");
    return false;
  }

  double member(const JsonValue& value, std::string_view label, std::string_view key, NumberRange range) {
    const auto found = json_.required(value, label, key);
    return found ? json_.number(*found, key, range) : 0;
  }

  Vec3 point(const JsonValue& value, std::string_view label) {
    if (!isObject(value, label)) return Vec3::Zero();
    return {member(value, label, "x", kMetres), member(value, label, "y", kMetres),
            member(value, label, "z", kMetres)};
  }

  std::array<double, 2> pair(const JsonValue& value, std::string_view label, NumberRange range) {
    if (!isObject(value, label)) return {0, 0};
    return {member(value, label, "x", range), member(value, label, "y", range)};
  }

  void users(const JsonValue& users) {
    if (!json_.array(users, "users")) return;
    bool isFirst = true;
    for (const JsonValue& user : users.children()) {
      if (!isObject(user, "users")) return;
      if (!isFirst) {
        warnings_.add("further user", user.line(), "a wall has one eye; left out");
        continue;
      }
      isFirst = false;
      for (const JsonValue& child : user.children()) {
        if (child.key() == "pos") {
          wall_.observer->eyeM = point(child, "pos");
        } else if (child.key() == "eyeseparation") {
          wall_.observer->separationMm = json_.number(child, "eyeseparation", {0, 10}) * 1000;
        } else if (child.key() != "name") {
          warnings_.add(excerpt(child.key(), 64) + " of a user", child.keyLine(),
                        "trackers say the eye to Tessera by OSC (\"osc_port\"); left out");
        }
      }
    }
  }

  void node(const JsonValue& node) {
    if (!isObject(node, "nodes")) return;
    std::string host;
    if (const auto address = node.find("address")) host = json_.string(*address, "address", 253);
    for (const JsonValue& child : node.children()) {
      if (child.key() == "windows") {
        if (!json_.array(child, "windows")) return;
        for (const JsonValue& window : child.children())
          this->window(window, host);
      } else if (child.key() != "address") {
        warnings_.add(excerpt(child.key(), 64) + " of a node", child.keyLine(), kLeftOut);
      }
    }
  }

  void window(const JsonValue& value, const std::string& host) {
    if (!isObject(value, "windows")) return;
    Window window;
    window.host = host;
    bool isFullscreen = false;
    for (const JsonValue& child : value.children()) {
      if (child.key() == "size") {
        const std::array<double, 2> size = pair(child, "size", {1, 16384});
        window.sizePx = {static_cast<int>(size[0]), static_cast<int>(size[1])};
      } else if (child.key() == "pos") {
        const std::array<double, 2> at = pair(child, "pos", {-32767, 32767});
        window.positionPx = {static_cast<int>(at[0]), static_cast<int>(at[1])};
      } else if (child.key() == "fullscreen") {
        isFullscreen = child.isTrue();
      } else if (child.key() == "stereo") {
        stereo(child);
      } else if (child.key() != "viewports" && child.key() != "name" && child.key() != "id" &&
                 child.key() != "border") {
        warnings_.add(excerpt(child.key(), 64) + " of a window", child.keyLine(), kLeftOut);
      }
    }
    if (isFullscreen) window.positionPx.reset();
    if (json_.ok() && window.sizePx[0] == 0) {
      window.sizePx = {1920, 1080};
      warnings_.add("window without a size in pixels", value.line(), "taken to have 1920 x 1080 pixels");
    }
    const auto viewports = value.find("viewports");
    if (!viewports) return;
    if (!json_.array(*viewports, "viewports")) return;
    for (const JsonValue& viewport : viewports->children())
      this->viewport(viewport, window);
  }

  void stereo(const JsonValue& value) {
    const std::string mode = json_.string(value, "stereo", 64);
    walltext::Stereo stereo = walltext::Stereo::None;
    if (mode == "active") {
      stereo = walltext::Stereo::QuadBuffer;
    } else if (mode == "side_by_side" || mode == "side_by_side_inverted") {
      stereo = walltext::Stereo::SideBySide;
    } else if (mode == "top_bottom" || mode == "top_bottom_inverted") {
      stereo = walltext::Stereo::TopBottom;
    } else if (mode != "none" && mode != "no_stereo") {
      warnings_.add("stereo mode " + excerpt(mode, 64), value.line(),
                    "not known to Tessera; shown without stereo");
    }
    if (mode.ends_with("_inverted")) {
      warnings_.add("stereo mode " + mode, value.line(), "Tessera has the left eye left or on top");
    }
    if (stereo == walltext::Stereo::None) return;
    if (stereo_ != walltext::Stereo::None && stereo_ != stereo) {
      warnings_.add("window with another stereo mode", value.line(), "a wall has one; the first holds");
      return;
    }
    stereo_ = stereo;
  }

  void viewport(const JsonValue& value, const Window& window) {
    if (!isObject(value, "viewports") || !json_.ok()) return;
    Part part;
    walltext::Tile tile;
    for (const JsonValue& child : value.children()) {
      if (child.key() == "pos") {
        const std::array<double, 2> at = pair(child, "pos", {-100, 100});
        part.x = at[0];
        part.y = at[1];
      } else if (child.key() == "size") {
        const std::array<double, 2> size = pair(child, "size", {0, 100});
        part.width = size[0];
        part.height = size[1];
      } else if (child.key() == "eye") {
        const std::string eye = json_.string(child, "eye", 64);
        if (eye == "left" || eye == "stereo_left") tile.settings.eye = walltext::Eye::Left;
        if (eye == "right" || eye == "stereo_right") tile.settings.eye = walltext::Eye::Right;
      } else if (child.key() != "projection" && child.key() != "type" && child.key() != "user" &&
                 child.key() != "tracked" && child.key() != "name") {
        warnings_.add(excerpt(child.key(), 64) + " of a viewport", child.keyLine(),
                      "not imported; Tessera takes warps and masks from MPCDI archives");
      }
    }
    const auto projection = value.find("projection");
    if (!projection || projection->kind() != JsonKind::Object) {
      warnings_.add("viewport without a projection", value.line(), "shows no flat screen; left out");
      return;
    }
    const auto type = json_.required(*projection, "projection", "type");
    if (!type) return;
    const std::string kind = json_.string(*type, "type", 64);
    walltext::Screen screen;
    if (kind == "ProjectionPlane") {
      screen.corners = plane(*projection);
    } else if (kind == "PlanarProjection") {
      screen.corners = planar(*projection);
    } else {
      if (curvedLine_ == 0) {
        curvedLine_ = projection->line();
        curved_ = kind;
      }
      warnings_.add("viewport with the projection " + kind, projection->line(),
                    "shows no flat screen; left out");
      return;
    }
    if (!json_.ok()) return;
    // Edges are rounded, not sizes, so that neighbours meet. A viewport's y counts from the window's bottom.
    const double width = window.sizePx[0], height = window.sizePx[1];
    const double left = std::round(part.x * width), right = std::round((part.x + part.width) * width);
    const double bottom = std::round(part.y * height), top = std::round((part.y + part.height) * height);
    tile.px = {static_cast<int>(right - left), static_cast<int>(top - bottom)};
    if (window.positionPx) {
      tile.settings.windowPx = {static_cast<int>((*window.positionPx)[0] + left),
                                static_cast<int>((*window.positionPx)[1] + height - top)};
    }
    tile.settings.host = window.host;
    tile.sizeMm = {lengthOf(screen.corners->lowerRight - screen.corners->lowerLeft) * 1000,
                   lengthOf(screen.corners->upperLeft - screen.corners->lowerLeft) * 1000};
    tile.name = screen.name = names_.make("screen" + std::to_string(wall_.screens.size()));
    screen.tiles.push_back(std::move(tile));
    wall_.screens.push_back(std::move(screen));
  }

  walltext::Corners plane(const JsonValue& value) {
    Vec3 lowerLeft = Vec3::Zero(), upperLeft = Vec3::Zero(), upperRight = Vec3::Zero();
    const auto corner = [&](const char* key, Vec3& to) {
      if (const auto found = json_.required(value, "projection", key)) to = point(*found, key);
    };
    corner("lowerleft", lowerLeft);
    corner("upperleft", upperLeft);
    corner("upperright", upperRight);
    return {lowerLeft, lowerLeft + upperRight - upperLeft, upperLeft};
  }

  /// A rectangle at some distance down the z axis from the room's origin (not from the user), turned by yaw
  /// to the right, pitch up and roll clockwise, and moved by an offset: so SGCT defines it.
  walltext::Corners planar(const JsonValue& value) {
    double left = 0, right = 0, down = 0, up = 0, distance = kPlanarDistanceM;
    if (const auto fov = json_.required(value, "projection", "fov"); fov && isObject(*fov, "fov")) {
      const auto half = [&](const char* whole, const char* one, double& to) {
        if (const auto found = fov->find(whole)) to = json_.number(*found, whole, {0, 179.98}) / 2;
        if (const auto found = fov->find(one)) to = json_.number(*found, one, kHalfField);
      };
      half("hfov", "left", left);
      half("hfov", "right", right);
      half("vfov", "down", down);
      half("vfov", "up", up);
      if (const auto found = fov->find("distance")) distance = json_.number(*found, "distance", {1e-3, 1e6});
      if (json_.ok() && (left + right <= 0 || down + up <= 0)) {
        json_.fail(fov->line(), "the field of view is empty",
                   "give hfov and vfov, or left, right, down and up");
      }
    }
    if (const auto found = value.find("distance")) distance = json_.number(*found, "distance", {1e-3, 1e6});
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    if (const auto orientation = value.find("orientation")) turn = this->orientation(*orientation);
    Vec3 offset = Vec3::Zero();
    if (const auto found = value.find("offset")) offset = point(*found, "offset");
    const auto at = [&](double x, double y) -> Vec3 {
      return turn * Vec3(distance * std::tan(x * kRadians), distance * std::tan(y * kRadians), -distance) +
             offset;
    };
    return {at(-left, -down), at(right, -down), at(-left, up)};
  }

  Eigen::Quaterniond orientation(const JsonValue& value) {
    if (!isObject(value, "orientation")) return Eigen::Quaterniond::Identity();
    if (value.find("w")) {
      Eigen::Quaterniond turn(
          member(value, "orientation", "w", {-1e6, 1e6}), member(value, "orientation", "x", {-1e6, 1e6}),
          member(value, "orientation", "y", {-1e6, 1e6}), member(value, "orientation", "z", {-1e6, 1e6}));
      if (!(turn.norm() > 1e-9)) json_.fail(value.line(), "\"orientation\" is no rotation");
      return turn.norm() > 1e-9 ? turn.normalized() : Eigen::Quaterniond::Identity();
    }
    const auto angle = [&](const char* key) {
      const auto found = value.find(key);
      return found ? json_.number(*found, key, kDegrees) * kRadians : 0;
    };
    return Eigen::AngleAxisd(-angle("yaw"), Vec3::UnitY()) *
           Eigen::AngleAxisd(angle("pitch"), Vec3::UnitX()) *
           Eigen::AngleAxisd(-angle("roll"), Vec3::UnitZ());
  }

  void finishStereo() {
    bool hasEyes = false;
    for (const walltext::Screen& screen : wall_.screens)
      hasEyes = hasEyes || screen.tiles[0].settings.eye != walltext::Eye::Both;
    wall_.observer->stereo = hasEyes ? walltext::Stereo::Tiles : stereo_;
  }

  JsonReader json_;
  std::string fileName_;
  WarningList warnings_;
  NameMaker names_;
  walltext::Wall wall_;
  walltext::Stereo stereo_ = walltext::Stereo::None;
  std::string curved_;
  int curvedLine_ = 0;
};

}  // namespace

Result<ImportedWall> importSgct(const JsonDocument& document, const std::string& fileName) {
  return Importer(fileName).run(document.root());
}

}  // namespace tessera

#include "common/wall/import/formats.h"
#include "common/wall/import/pixel_wall.h"
#include "common/wall/json_reader.h"

namespace tessera {

namespace {

const char* const kLeftOut = "not a part of a wall; left out";
constexpr NumberRange kPixels = {-1e6, 1e6};
constexpr NumberRange kCount = {1, 4096};
constexpr NumberRange kIndex = {0, 4095};

class Importer {
 public:
  explicit Importer(const std::string& fileName) : json_(fileName), fileName_(fileName) {}

  Result<ImportedWall> run(const JsonValue& root) {
    for (const JsonValue& child : root.children()) {
      if (child.key() == "surfaces") {
        if (!json_.array(child, "surfaces")) break;
        for (const JsonValue& surface : child.children())
          this->surface(surface);
      } else if (child.key() == "processes") {
        if (!json_.array(child, "processes")) break;
        for (const JsonValue& process : child.children())
          this->process(process);
      } else {
        leaveOut(child, "");
      }
    }
    if (json_.ok() && surfaces_.empty()) json_.fail(root.line(), "the file has no surface");
    if (!json_.ok()) return *json_.error();
    return wallOfPixels(surfaces_, screens_, std::move(warnings_),
                        "From the Tide configuration " + std::filesystem::path(fileName_).filename().string(),
                        fileName_);
  }

 private:
  void leaveOut(const JsonValue& value, const std::string& of) {
    warnings_.add(excerpt(value.key(), 64) + of, value.keyLine(), kLeftOut);
  }

  bool isObject(const JsonValue& value, std::string_view label) {
    if (value.kind() == JsonKind::Object) return true;
    json_.fail(value.line(), '"' + std::string(label) + "\" must hold objects");
    return false;
  }

  void surface(const JsonValue& value) {
    if (!isObject(value, "surfaces")) return;
    PixelSurface surface;
    surface.line = value.line();
    for (const JsonValue& child : value.children()) {
      const std::string_view key = child.key();
      if (key == "displayWidth") {
        surface.displayPx[0] = json_.integer(child, key, kPixels);
      } else if (key == "displayHeight") {
        surface.displayPx[1] = json_.integer(child, key, kPixels);
      } else if (key == "displaysPerScreenX") {
        surface.displaysPerScreen[0] = json_.integer(child, key, kCount);
      } else if (key == "displaysPerScreenY") {
        surface.displaysPerScreen[1] = json_.integer(child, key, kCount);
      } else if (key == "screenCountX") {
        surface.screenCount[0] = json_.integer(child, key, kCount);
      } else if (key == "screenCountY") {
        surface.screenCount[1] = json_.integer(child, key, kCount);
      } else if (key == "bezelWidth") {
        surface.bezelPx[0] = json_.integer(child, key, kPixels);
      } else if (key == "bezelHeight") {
        surface.bezelPx[1] = json_.integer(child, key, kPixels);
      } else if (key == "dimensions") {
        dimensions(child, surface);
      } else {
        leaveOut(child, " of a surface");
      }
    }
    surfaces_.push_back(surface);
  }

  void dimensions(const JsonValue& value, PixelSurface& surface) {
    std::vector<JsonValue> sides = value.children();
    if (sides.size() != 2 || value.kind() == JsonKind::String) {
      json_.fail(value.line(), "\"dimensions\" must be the width and height in metres");
      return;
    }
    if (value.kind() == JsonKind::Object && sides[0].key() == "height") std::swap(sides[0], sides[1]);
    for (std::size_t axis = 0; axis < 2; ++axis)
      surface.sizeM[axis] = json_.number(sides[axis], "dimensions", {0, 1000});
  }

  void process(const JsonValue& value) {
    if (!isObject(value, "processes")) return;
    std::string host;
    if (const auto found = value.find("host")) host = json_.string(*found, "host", 253);
    for (const JsonValue& child : value.children()) {
      if (child.key() == "screens") {
        if (!json_.array(child, "screens")) return;
        for (const JsonValue& screen : child.children())
          this->screen(screen, host);
      } else if (child.key() != "host") {
        leaveOut(child, " of a process");
      }
    }
  }

  void screen(const JsonValue& value, const std::string& host) {
    if (!isObject(value, "screens")) return;
    PixelScreen screen;
    screen.host = host;
    screen.line = value.line();
    for (const JsonValue& child : value.children()) {
      const std::string_view key = child.key();
      if (key == "i") {
        screen.column = json_.integer(child, key, kIndex);
      } else if (key == "j") {
        screen.row = json_.integer(child, key, kIndex);
      } else if (key == "x") {
        screen.windowPx[0] = json_.integer(child, key, kPixels);
      } else if (key == "y") {
        screen.windowPx[1] = json_.integer(child, key, kPixels);
      } else if (key == "surface") {
        screen.surface = json_.integer(child, key, kIndex);
      } else if (key == "fullscreen") {
        screen.isFullscreen = child.isTrue();
      } else if (key == "stereo") {
        const std::string eye = json_.string(child, key, 64);
        if (eye == "left") screen.eye = walltext::Eye::Left;
        if (eye == "right") screen.eye = walltext::Eye::Right;
        if (eye != "left" && eye != "right" && eye != "mono" && eye != "none" && !eye.empty()) {
          warnings_.add("screen of an unknown stereo mode", child.line(), "taken to show both eyes");
        }
      } else if (key == "display") {
        if (child.string() != ":0" && !child.string().empty()) {
          warnings_.add(
              "X display of a screen", child.line(),
              "which display a tile's program opens its window on is not said in a wall file; left out");
        }
      } else {
        leaveOut(child, " of a screen");
      }
    }
    screens_.push_back(std::move(screen));
  }

  JsonReader json_;
  std::string fileName_;
  WarningList warnings_;
  std::vector<PixelSurface> surfaces_;
  std::vector<PixelScreen> screens_;
};

}  // namespace

Result<ImportedWall> importTide(const JsonDocument& document, const std::string& fileName) {
  return Importer(fileName).run(document.root());
}

}  // namespace tessera

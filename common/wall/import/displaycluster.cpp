#include <algorithm>
#include <charconv>
#include <optional>

#include <pugixml.hpp>

#include "common/wall/import/formats.h"
#include "common/wall/import/pixel_wall.h"

namespace tessera {

namespace {

const char* const kLeftOut = "not a part of a wall; left out";

class Importer {
 public:
  Importer(std::string_view text, const std::string& fileName) : text_(text), fileName_(fileName) {}

  Result<ImportedWall> run(const pugi::xml_node& root) {
    for (const pugi::xml_node& child : root.children()) {
      if (child.type() != pugi::node_element) continue;
      const std::string_view name = child.name();
      if (name == "dimensions") {
        dimensions(child);
      } else if (name == "process") {
        process(child);
      } else {
        warnings_.add(std::string(name.substr(0, 64)), lineOf(child), kLeftOut);
      }
    }
    if (!hasDimensions_) fail(root, "the file has no <dimensions> of a wall");
    if (error_) return *error_;
    for (PixelScreen& screen : screens_)
      screen.isFullscreen = screen.isFullscreen || isFullscreen_;
    return wallOfPixels(
        {surface_}, screens_, std::move(warnings_),
        "From the DisplayCluster configuration " + std::filesystem::path(fileName_).filename().string(),
        fileName_);
  }

 private:
  void fail(const pugi::xml_node& node, std::string what) {
    if (!error_) error_ = inputError(fileName_ + ':' + std::to_string(lineOf(node)), std::move(what));
  }

  [[nodiscard]] int lineOf(const pugi::xml_node& node) const {
    const auto offset = static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text_.size()));
    return static_cast<int>(1 + std::count(text_.begin(), end, '\n'));
  }

  int integer(const pugi::xml_node& node, const pugi::xml_attribute& attribute, int least, int most) {
    const std::string_view text = attribute.value();
    int value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc{} || end != text.data() + text.size() || value < least || value > most) {
      fail(node, std::string("\"") + attribute.name() + "\" must be a whole number from " +
                     std::to_string(least) + " to " + std::to_string(most));
      return least;
    }
    return value;
  }

  double metres(const pugi::xml_node& node, const pugi::xml_attribute& attribute) {
    const std::string_view text = attribute.value();
    double value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc{} || end != text.data() + text.size() || !(value >= 0 && value <= 1000)) {
      fail(node, std::string("\"") + attribute.name() + "\" must be a length from 0 to 1000 metres");
      return 0;
    }
    return value;
  }

  void dimensions(const pugi::xml_node& node) {
    if (hasDimensions_) fail(node, "a second <dimensions> in one file");
    hasDimensions_ = true;
    surface_.line = lineOf(node);
    constexpr int kMostPx = 1'000'000, kMostTiles = 4096;
    for (const pugi::xml_attribute& attribute : node.attributes()) {
      const std::string_view name = attribute.name();
      if (name == "numTilesWidth" || name == "numScreensX") {
        surface_.screenCount[0] = integer(node, attribute, 1, kMostTiles);
      } else if (name == "numTilesHeight" || name == "numScreensY") {
        surface_.screenCount[1] = integer(node, attribute, 1, kMostTiles);
      } else if (name == "screenWidth" || name == "displayWidth") {
        surface_.displayPx[0] = integer(node, attribute, 1, kMostPx);
      } else if (name == "screenHeight" || name == "displayHeight") {
        surface_.displayPx[1] = integer(node, attribute, 1, kMostPx);
      } else if (name == "mullionWidth" || name == "bezelWidth") {
        surface_.bezelPx[0] = integer(node, attribute, -kMostPx, kMostPx);
      } else if (name == "mullionHeight" || name == "bezelHeight") {
        surface_.bezelPx[1] = integer(node, attribute, -kMostPx, kMostPx);
      } else if (name == "displaysPerScreenX") {
        surface_.displaysPerScreen[0] = integer(node, attribute, 1, kMostTiles);
      } else if (name == "displaysPerScreenY") {
        surface_.displaysPerScreen[1] = integer(node, attribute, 1, kMostTiles);
      } else if (name == "physicalWidth") {
        surface_.sizeM[0] = metres(node, attribute);
      } else if (name == "physicalHeight") {
        surface_.sizeM[1] = metres(node, attribute);
      } else if (name == "fullscreen") {
        isFullscreen_ = std::string_view(attribute.value()) == "1" || attribute.as_bool();
      } else {
        warnings_.add(std::string(name.substr(0, 64)) + " of the dimensions", surface_.line, kLeftOut);
      }
    }
  }

  void display(const pugi::xml_node& node, const pugi::xml_attribute& attribute) {
    const std::string_view value = attribute.value();
    if (value.empty() || value == ":0") return;
    warnings_.add("X display", lineOf(node),
                  "which display a tile's program opens its window on is not said in a wall file; left out");
  }

  void process(const pugi::xml_node& node) {
    std::string host;
    for (const pugi::xml_attribute& attribute : node.attributes()) {
      const std::string_view name = attribute.name();
      if (name == "host") {
        host = attribute.value();
      } else if (name == "display") {
        display(node, attribute);
      } else {
        warnings_.add(std::string(name.substr(0, 64)) + " of a process", lineOf(node), kLeftOut);
      }
    }
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      if (std::string_view(child.name()) == "screen") {
        screen(child, host);
      } else {
        warnings_.add(std::string(std::string_view(child.name()).substr(0, 64)) + " of a process",
                      lineOf(child), kLeftOut);
      }
    }
  }

  void screen(const pugi::xml_node& node, const std::string& host) {
    PixelScreen screen;
    screen.host = host;
    screen.line = lineOf(node);
    constexpr int kMostPx = 1'000'000, kMostIndex = 4095;
    for (const pugi::xml_attribute& attribute : node.attributes()) {
      const std::string_view name = attribute.name();
      if (name == "x") {
        screen.windowPx[0] = integer(node, attribute, -kMostPx, kMostPx);
      } else if (name == "y") {
        screen.windowPx[1] = integer(node, attribute, -kMostPx, kMostPx);
      } else if (name == "i") {
        screen.column = integer(node, attribute, 0, kMostIndex);
      } else if (name == "j") {
        screen.row = integer(node, attribute, 0, kMostIndex);
      } else if (name == "stereo") {
        const std::string_view eye = attribute.value();
        if (eye == "left") screen.eye = walltext::Eye::Left;
        if (eye == "right") screen.eye = walltext::Eye::Right;
      } else if (name == "display") {
        display(node, attribute);
      } else {
        warnings_.add(std::string(name.substr(0, 64)) + " of a screen", screen.line, kLeftOut);
      }
    }
    screens_.push_back(std::move(screen));
  }

  std::string_view text_;
  std::string fileName_;
  std::optional<Error> error_;
  WarningList warnings_;
  PixelSurface surface_;
  std::vector<PixelScreen> screens_;
  bool hasDimensions_ = false, isFullscreen_ = false;
};

}  // namespace

Result<ImportedWall> importDisplayCluster(const pugi::xml_document& document, std::string_view text,
                                          const std::string& fileName) {
  return Importer(text, fileName).run(document.document_element());
}

}  // namespace tessera

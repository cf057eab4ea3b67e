#include "common/wall/wall_writer.h"

#include <charconv>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "common/wall/json_reader.h"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegPerRadian = 180 / std::numbers::pi;

Json array(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// The fifteenth digit is the rounding of unit conversions, which nobody wants to read.
double tidy(double x) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, x, std::chars_format::general, 15);
  double tidied = x;
  std::from_chars(text, end.ptr, tidied);
  return tidied;
}

Json tileJson(const Tile& tile, const Screen& screen) {
  const Vec2 middle = (tile.corners[0] + tile.corners[2]) / 2;
  const bool isTurned = tile.quarterTurns % 2 != 0;
  const Vec2 half =
      (tile.corners[2] - tile.corners[0]).cwiseProduct(Vec2(screen.widthMm, screen.heightMm)) / 2;
  const double width = tile.freeTurnRad != 0 ? tile.widthMm : isTurned ? half.y() : half.x();
  const double height = tile.freeTurnRad != 0 ? tile.heightMm : isTurned ? half.x() : half.y();
  const TileOutput& output = tile.output;
  Json json = {
      {"name", tile.name},
      {"px", {tile.widthPx, tile.heightPx}},
      {"size_mm", {tidy(width), tidy(height)}},
      {"center_mm",
       {tidy((middle.x() + 1) * screen.widthMm / 2), tidy((1 - middle.y()) * screen.heightMm / 2)}},
      {"rotation_deg", tile.freeTurnRad != 0 ? tile.freeTurnRad * kDegPerRadian : 90.0 * tile.quarterTurns}};
  if (!output.host.empty()) json["host"] = output.host;
  if (!output.monitor.empty()) json["monitor"] = output.monitor;
  if (output.windowPx) json["window_px"] = *output.windowPx;
  constexpr std::array kEyes = {"both", "left", "right"};
  json["eye"] = kEyes[static_cast<std::size_t>(tile.eye)];
  json["gain_rgb"] = output.gainRgb;
  json["black_rgb"] = output.blackRgb;
  json["gamma"] = output.gamma;
  json["blend_px"] = {{"left", output.blendPx[0]},
                      {"right", output.blendPx[1]},
                      {"bottom", output.blendPx[2]},
                      {"top", output.blendPx[3]}};
  if (!output.warpFile.empty()) json["warp"] = {{"mpcdi", output.warpFile}, {"region", output.warpRegion}};
  return json;
}

Json screenJson(const Wall& wall, const Screen& screen, bool hasPlace) {
  Json json = {{"name", screen.name}};
  if (hasPlace) {
    const Vec3 right = screen.right * (screen.widthMm / 2000), up = screen.up * (screen.heightMm / 2000);
    json["corners_m"] = {{"lower_left", array(screen.centerM - right - up)},
                         {"lower_right", array(screen.centerM + right - up)},
                         {"upper_left", array(screen.centerM - right + up)}};
  } else {
    json["size_mm"] = {screen.widthMm, screen.heightMm};
  }
  Json tiles = Json::array();
  for (std::uint32_t t = screen.firstTile; t < screen.firstTile + screen.tileCount; ++t)
    tiles.push_back(tileJson(wall.tiles[t], screen));
  json["tiles"] = std::move(tiles);
  return json;
}

Json observerJson(const Observer& observer) {
  constexpr std::array kModes = {"none", "side-by-side", "top-bottom", "tiles", "quad-buffer"};
  Json json = {{"eye_m", array(observer.eyeM)}, {"scale", observer.scale}};
  if (observer.oscPort > 0) json["osc_port"] = observer.oscPort;
  json["stereo"] = {{"mode", kModes[static_cast<std::size_t>(observer.stereo)]},
                    {"separation_mm", tidy(observer.separationM * 1000)}};
  return json;
}

}  // namespace

std::string writeWall(const Wall& wall) {
  Json json = {{"$schema", "wall.schema.json"}, {"name", wall.name}};
  Json screens = Json::array();
  for (const Screen& screen : wall.screens)
    screens.push_back(screenJson(wall, screen, wall.observer.has_value()));
  json["screens"] = std::move(screens);
  Json camera = Json::object();
  if (!wall.observer) camera["fov_y_deg"] = tidy(wall.fovYRad * kDegPerRadian);
  if (wall.near) camera["near_m"] = *wall.near;
  if (wall.far) camera["far_m"] = *wall.far;
  json["camera"] = std::move(camera);
  if (wall.observer) json["observer"] = observerJson(*wall.observer);
  std::string comment = "// " + wall.source + ", with every default.";
  if (!wall.near || !wall.far)
    comment += " Clip distances that are not given are fitted to the scene in every frame.";
  return comment + "\n" + json.dump(2) + "\n";
}

std::string writeNewWall(const WallRequest& request) {
  const auto pair = [](double a, double b) { return "[" + numberText(a) + ", " + numberText(b) + "]"; };
  std::string text =
      "// Every key is described in wall.schema.json; tessera check --wall FILE --svg PICTURE draws it.\n{\n";
  text += "  \"$schema\": \"wall.schema.json\",\n";
  if (!request.name.empty()) text += "  \"name\": " + Json(request.name).dump() + ",\n";
  text += "  \"grid\": {\n    \"columns\": " + std::to_string(request.columns) +
          ",\n    \"rows\": " + std::to_string(request.rows) +
          ",\n    \"tile_px\": " + pair(request.tileWidthPx, request.tileHeightPx);
  if (request.tileMm) text += ",\n    \"tile_mm\": " + pair((*request.tileMm)[0], (*request.tileMm)[1]);
  if (request.bezelMm) text += ",\n    \"bezel_mm\": " + numberText(*request.bezelMm);
  if (request.compresses) text += ",\n    \"bezel\": \"compress\"";
  if (request.overlapPx)
    text += ",\n    \"overlap_px\": " + pair((*request.overlapPx)[0], (*request.overlapPx)[1]);
  if (request.rotationDeg != 0) text += ",\n    \"rotation_deg\": " + std::to_string(request.rotationDeg);
  return text + "\n  },\n  \"camera\": {\"fov_y_deg\": " + numberText(request.fovYDeg) + "}\n}\n";
}

Result<std::array<double, 2>> parsePair(std::string_view text, const std::string& what) {
  const std::size_t x = text.find('x');
  std::array<double, 2> both{};
  const auto number = [](std::string_view part, double& to) {
    const auto [end, ec] = std::from_chars(part.data(), part.data() + part.size(), to);
    return ec == std::errc() && end == part.data() + part.size() && std::isfinite(to) && to > 0;
  };
  if (x == std::string_view::npos || !number(text.substr(0, x), both[0]) ||
      !number(text.substr(x + 1), both[1]))
    return inputError(what, "\"" + excerpt(text, 64) + "\" is no pair of sizes", "write it as 1920x1080");
  return both;
}

Result<double> parseLengthMm(std::string_view text, const std::string& what, double bareMm) {
  double value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const double factor = unit.empty()   ? bareMm
                        : unit == "mm" ? 1
                        : unit == "cm" ? 10
                        : unit == "m"  ? 1000
                        : unit == "in" ? 25.4
                                       : 0;
  if (ec != std::errc() || factor == 0 || !std::isfinite(value))
    return inputError(what, "\"" + excerpt(text, 64) + "\" is no length",
                      "write it as 12mm, 1.2cm, 0.012m or 0.5in");
  if (value < 0)
    return inputError(what, "\"" + excerpt(text, 64) + "\" is negative", "a length is 0 or more");
  return value * factor;
}

}  // namespace tessera

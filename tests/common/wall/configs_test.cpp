#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/file.h"
#include "common/wall/camera_path.h"
#include "common/wall/json_document.h"
#include "common/wall/json_reader.h"
#include "common/wall/wall_file.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

const fs::path kConfigs = fs::path(TESSERA_SOURCE_DIR) / "configs";

std::vector<fs::path> shippedFiles() {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(kConfigs)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

JsonDocument loaded(const fs::path& path) {
  const Result<std::string> text = readFile(path, kMaxWallFileBytes);
  EXPECT_TRUE(text.ok()) << text.error().text();
  Result<JsonDocument> document = JsonDocument::parse(*text, path.string());
  EXPECT_TRUE(document.ok()) << document.error().text();
  return *std::move(document);
}

TEST(Configs, everyShippedFileLoads) {
  const std::vector<fs::path> files = shippedFiles();
  EXPECT_GE(files.size(), 9u);
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    SCOPED_TRACE(name);
    if (name.ends_with(".schema.json")) {
      EXPECT_EQ(loaded(file).root().find("$schema")->string(),
                "https://json-schema.org/draft/2020-12/schema");
      continue;
    }
    const bool isCamera = name.ends_with(".camera.json");
    EXPECT_EQ(loaded(file).root().find("$schema")->string(),
              isCamera ? "camera.schema.json" : "wall.schema.json");
    if (isCamera) {
      const Result<CameraPath> path = readCameraPath(file);
      EXPECT_TRUE(path.ok()) << path.error().text();
    } else {
      const Result<Wall> wall = readWallFile(file);
      ASSERT_TRUE(wall.ok()) << wall.error().text();
      EXPECT_TRUE(wall->warnings.empty()) << wall->warnings[0];
      const Screen& screen = wall->screens[0];
      if (wall->screens.size() == 1 && screen.columns > 0) {
        const std::string grid = std::to_string(screen.columns) + "x" + std::to_string(screen.rows);
        EXPECT_TRUE(name.ends_with("-" + grid + ".json")) << grid;
      }
    }
  }
  for (const char* name :
       {"wall-1x1.json", "wall-2x2.json", "wall-3x2.json", "wall-4x4.json", "wall-8x8.json",
        "wall-16x16.json", "wall-bezels-4x3.json", "wall-mixed.json", "wall-portrait-4x1.json",
        "wall-projectors-3x1.json", "wall-cave-4.json", "wall-curved-6x2.json", "wall-stereo-2x1.json",
        "wall-dome.json", "orbit.camera.json", "fly.camera.json", "dive.camera.json"}) {
    EXPECT_TRUE(fs::exists(kConfigs / name)) << name;
  }
}

TEST(Configs, orbitKeepsTheWholeSceneInView) {
  const Result<CameraPath> path = readCameraPath(kConfigs / "orbit.camera.json");
  ASSERT_TRUE(path.ok()) << path.error().text();
  EXPECT_EQ(path->space(), CameraSpace::Scene);
  EXPECT_EQ(path->keyframes().back().timeS, 20);
  EXPECT_EQ(path->keyframes().front().eye, path->keyframes().back().eye);
  for (const double timeS : path->sampleTimes(2001)) {
    const CameraPose pose = path->poseAt(timeS, Vec3::Zero(), 1);
    EXPECT_EQ(pose.target, Vec3(0, 0, 0));
    EXPECT_GE(pose.eye.norm(), 2.37) << timeS;  // 1 / sin(25 degrees)
    EXPECT_LE(pose.eye.norm(), 3) << timeS;
    EXPECT_GT(pose.eye.y(), 0) << timeS;
  }
}

TEST(Configs, flyStaysInsideTheScene) {
  const Result<CameraPath> path = readCameraPath(kConfigs / "fly.camera.json");
  ASSERT_TRUE(path.ok()) << path.error().text();
  EXPECT_EQ(path->keyframes().back().timeS, 40);
  EXPECT_EQ(path->keyframes().front().eye, path->keyframes().back().eye);
  for (const double timeS : path->sampleTimes(2001)) {
    const CameraPose pose = path->poseAt(timeS, Vec3::Zero(), 1);
    EXPECT_LE(pose.eye.norm(), 0.9) << timeS;
    EXPECT_GE(pose.eye.y(), 0.03) << timeS;
    EXPECT_LE(pose.eye.y(), 0.2) << timeS;
  }
}

TEST(Configs, diveGoesFromAllInViewToNothing) {
  const Result<CameraPath> path = readCameraPath(kConfigs / "dive.camera.json");
  ASSERT_TRUE(path.ok()) << path.error().text();
  // The angle from the view direction to the scene's centre, and the scene's angular radius.
  const auto angles = [&](double timeS) {
    const CameraPose pose = path->poseAt(timeS, Vec3::Zero(), 1);
    const Vec3 forward = (pose.target - pose.eye).normalized();
    return std::pair(std::acos(std::min(1.0, forward.dot(-pose.eye.normalized()))),
                     std::asin(1 / pose.eye.norm()));
  };
  constexpr double kDeg = std::numbers::pi / 180;
  const auto [firstAngle, firstRadius] = angles(0);
  EXPECT_LT(firstAngle + firstRadius, 25 * kDeg);
  const auto [lastAngle, lastRadius] = angles(path->keyframes().back().timeS);
  EXPECT_GT(lastAngle - lastRadius, 45 * kDeg);  // half the diagonal of a 16:9 wall of 50 degrees is 43.6
}

/// The keys that the reader lists when it meets an unknown one.
std::set<std::string> keysInError(const Error& error) {
  const std::string marker = "Known keys: ";
  std::set<std::string> keys;
  const std::size_t at = error.mend.find(marker);
  if (at == std::string::npos) return keys;
  std::istringstream list(error.mend.substr(at + marker.size()));
  for (std::string key; std::getline(list >> std::ws, key, ',');)
    keys.insert(key);
  return keys;
}

std::set<std::string> keysInSchema(const JsonValue& object) {
  EXPECT_EQ(object.find("additionalProperties")->kind(), JsonKind::Boolean);
  std::set<std::string> keys;
  for (const JsonValue& property : object.find("properties")->children()) {
    EXPECT_TRUE(property.find("description").has_value()) << property.key();
    keys.emplace(property.key());
  }
  return keys;
}

template <class T>
std::set<std::string> keysInReader(const Result<T>& result) {
  EXPECT_FALSE(result.ok());
  return result.ok() ? std::set<std::string>{} : keysInError(result.error());
}

TEST(Configs, schemaAndReaderAgreeOnTheKeys) {
  const JsonDocument wallSchema = loaded(kConfigs / "wall.schema.json");
  const JsonValue wall = wallSchema.root();
  const JsonValue properties = *wall.find("properties");
  const JsonValue defs = *wall.find("$defs"), screen = *properties.find("screens")->find("items");
  const JsonValue observer = *properties.find("observer");
  const auto expectKeys = [](const std::string& text, const JsonValue& described) {
    EXPECT_EQ(keysInReader(parseWall(text, "w")), keysInSchema(described)) << text;
  };
  const std::string grid = R"("grid": {"columns": 1, "rows": 1, "tile_px": [8, 8])";
  expectKeys(R"({"?": 1})", wall);
  expectKeys(R"({"grid": {"?": 1}})", *defs.find("grid"));
  expectKeys("{" + grid + R"(}, "camera": {"?": 1}})", *properties.find("camera"));
  expectKeys("{" + grid + R"(, "tile": {"?": 1}}})", *defs.find("settings"));
  expectKeys("{" + grid + R"(}, "tiles": {"r0c0": {"?": 1}}})", *defs.find("settings"));
  expectKeys("{" + grid + R"(, "bezel_mm": {"?": 1}}})",
             defs.find("grid")->find("properties")->find("bezel_mm")->find("oneOf")->children()[2]);
  expectKeys(R"({"screens": [{"?": 1}]})", screen);
  expectKeys(R"({"screens": [{"corners_m": {"?": 1}}]})", *screen.find("properties")->find("corners_m"));
  expectKeys(R"({"screens": [{"tiles": [{"?": 1}]}]})", *defs.find("tile"));
  expectKeys("{" + grid + R"(}, "tiles": {"r0c0": {"warp": {"?": 1}}}})",
             *defs.find("settings")->find("properties")->find("warp"));
  expectKeys(R"({"observer": {"?": 1}})", observer);
  expectKeys(R"({"observer": {"eye_m": [0, 0, 1], "stereo": {"?": 1}}})",
             *observer.find("properties")->find("stereo"));

  const JsonDocument cameraSchema = loaded(kConfigs / "camera.schema.json");
  const JsonValue camera = cameraSchema.root();
  EXPECT_EQ(keysInReader(parseCameraPath(R"({"?": 1})", "c")), keysInSchema(camera));
  EXPECT_EQ(keysInReader(parseCameraPath(R"({"space": "world", "keyframes": [{"?": 1}]})", "c")),
            keysInSchema(*camera.find("properties")->find("keyframes")->find("items")));
}

std::string wallWith(const std::string& key, const std::string& value) {
  std::string columns = "1", rows = "1", tilePx = "8", camera;
  if (key == "columns")
    columns = value;
  else if (key == "rows")
    rows = value;
  else if (key == "tile_px")
    tilePx = value;
  else
    camera = "\"" + key + "\": " + value;
  return "{\"grid\": {\"columns\": " + columns + ", \"rows\": " + rows + ", \"tile_px\": [" + tilePx +
         ", 8]}, \"camera\": {" + camera + "}}";
}

TEST(Configs, schemaAndReaderAgreeOnTheLimits) {
  const JsonDocument schema = loaded(kConfigs / "wall.schema.json");
  const JsonValue properties = *schema.root().find("properties");
  int checkedCount = 0;
  for (const JsonValue& part : {*schema.root().find("$defs")->find("grid"), *properties.find("camera")}) {
    for (const JsonValue& property : part.find("properties")->children()) {
      const std::string key(property.key());
      const JsonValue limits = key == "tile_px" ? *property.find("items") : property;
      if (!limits.find("minimum")) continue;
      SCOPED_TRACE(key);
      ++checkedCount;
      const double least = limits.find("minimum")->number();
      const double most = limits.find("maximum")->number();
      EXPECT_TRUE(parseWall(wallWith(key, numberText(least)), "w").ok());
      EXPECT_TRUE(parseWall(wallWith(key, numberText(most)), "w").ok());
      const bool isWhole = limits.find("type")->string() == "integer";
      const double below = isWhole ? least - 1 : std::nextafter(least, -1.0);
      const double above = isWhole ? most + 1 : std::nextafter(most, 1e300);
      EXPECT_FALSE(parseWall(wallWith(key, numberText(below)), "w").ok());
      EXPECT_FALSE(parseWall(wallWith(key, numberText(above)), "w").ok());
    }
  }
  EXPECT_EQ(checkedCount, 6);
  const JsonValue fov = *properties.find("camera")->find("properties")->find("fov_y_deg");
  EXPECT_EQ(fov.find("default")->number(), kDefaultFovYDeg);
}

}  // namespace
}  // namespace tessera

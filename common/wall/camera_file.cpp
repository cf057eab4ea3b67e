#include <cmath>
#include <numbers>

#include "common/base/file.h"
#include "common/wall/camera_path.h"
#include "common/wall/json_document.h"
#include "common/wall/json_reader.h"
#include "common/wall/view_axes.h"

namespace tessera {

namespace {

constexpr NumberRange kCoordinateRange{-kMaxCameraCoordinate, kMaxCameraCoordinate};
constexpr NumberRange kHeadRangeM{-1000, 1000};

CameraSpace readSpace(JsonReader& json, const JsonValue& value) {
  const std::string space = json.string(value, "space", 64);
  if (space == "scene") return CameraSpace::Scene;
  if (space != "world") {
    json.fail(value.line(), "\"space\" must be \"world\" or \"scene\", not \"" + space + '"',
              "did you mean \"" + std::string(nearestWord(space, {"world", "scene"})) + "\"?");
  }
  return CameraSpace::World;
}

/// What no single number tells: whether the keyframe is a view at all.
void checkView(JsonReader& json, const JsonValue& value, const CameraKeyframe& keyframe) {
  if (!json.ok()) return;
  const std::optional<Vec3> forward = direction(keyframe.target - keyframe.eye);
  if (!forward) {
    return json.fail(value.find("target")->line(), "\"eye\" and \"target\" are the same point",
                     "move one of them");
  }
  if (upAcross(*forward, keyframe.up)) return;
  const std::optional<JsonValue> up = value.find("up");
  if (!direction(keyframe.up)) return json.fail(up->line(), "\"up\" has no length", "give it a direction");
  json.fail(up ? up->line() : value.line(), "\"up\" lies along the view from \"eye\" to \"target\"",
            "give an \"up\" that points aside, such as [0, 0, -1]");
}

CameraKeyframe readKeyframe(JsonReader& json, const JsonValue& value) {
  CameraKeyframe keyframe;
  if (!json.object(value, "keyframe", {"time_s", "eye", "target", "up", "fov_y_deg", "head_m"}))
    return keyframe;
  if (const auto time = json.required(value, "keyframe", "time_s")) {
    keyframe.timeS = json.number(*time, "time_s", {-kMaxCameraTimeS, kMaxCameraTimeS});
  }
  if (const auto eye = json.required(value, "keyframe", "eye")) {
    keyframe.eye = json.vec3(*eye, "eye", kCoordinateRange);
  }
  if (const auto target = json.required(value, "keyframe", "target")) {
    keyframe.target = json.vec3(*target, "target", kCoordinateRange);
  }
  if (const auto up = value.find("up")) keyframe.up = json.vec3(*up, "up", kCoordinateRange);
  if (const auto fov = value.find("fov_y_deg")) {
    keyframe.fovYRad = json.number(*fov, "fov_y_deg", {kMinFovYDeg, kMaxFovYDeg}) * (std::numbers::pi / 180);
  }
  if (const auto head = value.find("head_m")) keyframe.headM = json.vec3(*head, "head_m", kHeadRangeM);
  checkView(json, value, keyframe);
  return keyframe;
}

/// What a keyframe must share with the one before it.
void checkSuccession(JsonReader& json, const JsonValue& value, const CameraKeyframe& before,
                     const CameraKeyframe& keyframe) {
  if (!json.ok()) return;
  if (!(keyframe.timeS - before.timeS >= kMinKeyframeStepS)) {
    return json.fail(value.find("time_s")->line(),
                     "\"time_s\" (" + numberText(keyframe.timeS) +
                         ") must be greater than that of the keyframe before (" + numberText(before.timeS) +
                         ")",
                     "put the keyframes in order, at least " + numberText(kMinKeyframeStepS) + " s apart");
  }
  const auto checkAlike = [&](const char* key, bool isHere, bool wasThere) {
    if (isHere == wasThere) return;
    json.fail(isHere ? value.find(key)->line() : value.line(),
              std::string("\"") + key + "\" is " +
                  (isHere ? "given, but not in" : "not given, but it is in") + " the keyframe before",
              "give it in all keyframes or in none");
  };
  checkAlike("fov_y_deg", keyframe.fovYRad.has_value(), before.fovYRad.has_value());
  checkAlike("head_m", keyframe.headM.has_value(), before.headM.has_value());
}

std::vector<CameraKeyframe> readKeyframes(JsonReader& json, const JsonValue& value) {
  std::vector<CameraKeyframe> keyframes;
  if (!json.array(value, "keyframes")) return keyframes;
  for (const JsonValue& element : value.children()) {
    const CameraKeyframe keyframe = readKeyframe(json, element);
    if (!keyframes.empty()) checkSuccession(json, element, keyframes.back(), keyframe);
    if (!json.ok()) {
      json.prefixError("keyframe " + std::to_string(keyframes.size()) + ": ");
      return keyframes;
    }
    keyframes.push_back(keyframe);
  }
  if (keyframes.empty()) json.fail(value.line(), "\"keyframes\" is empty", "give at least one keyframe");
  return keyframes;
}

}  // namespace

Result<CameraPath> readCameraPath(const std::filesystem::path& path) {
  const Result<std::string> text = readFile(path, kMaxCameraFileBytes);
  if (!text) return text.error();
  return parseCameraPath(*text, path.string());
}

Result<CameraPath> parseCameraPath(std::string_view text, const std::string& sourceName) {
  const Result<JsonDocument> document = JsonDocument::parse(text, sourceName);
  if (!document) return document.error();
  JsonReader json(sourceName);
  const JsonValue root = document->root();
  CameraSpace space = CameraSpace::World;
  std::vector<CameraKeyframe> keyframes;
  if (json.object(root, "camera path", {"$schema", "name", "space", "keyframes"})) {
    constexpr std::size_t kLongestTextBytes = 256;
    if (const auto schema = root.find("$schema")) json.string(*schema, "$schema", kLongestTextBytes);
    if (const auto name = root.find("name")) json.string(*name, "name", kLongestTextBytes);
    if (const auto value = json.required(root, "camera path", "space")) space = readSpace(json, *value);
    if (const auto value = json.required(root, "camera path", "keyframes")) {
      keyframes = readKeyframes(json, *value);
    }
  }
  if (json.error()) return *json.error();
  return CameraPath(space, std::move(keyframes));
}

}  // namespace tessera

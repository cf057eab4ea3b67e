#include "server/bench/targets.h"

#include <algorithm>
#include <array>

namespace tessera::bench {

namespace {

Result<Scene> powerPlantScene(PaperScenes& scenes) {
  auto plant = scenes.powerPlant();
  if (!plant) return plant.error();
  return Scene(**plant);
}

struct Case {
  const char* name;
  Result<Scene> (*load)(PaperScenes&);
  Result<TargetFigures> (*measure)(const Scene&, double);
};

constexpr std::array kCases = {
    Case{"P", powerPlantScene, powerPlantTargets},
    Case{"C1", [](PaperScenes& scenes) { return scenes.city(100'000); }, cityTargets},
    Case{"C2", [](PaperScenes& scenes) { return scenes.city(1'000'000); }, millionTargets},
};

Json figureJson(const TargetFigure& figure) {
  Json json = {
      {"name", figure.name},
      {"frames", figure.frames},
      {"camera_step",
       {{"degrees_per_frame", figure.step.degrees}, {"scene_radii_per_frame", figure.step.sceneRadii}}}};
  if (figure.target) {
    json["target"] = *figure.target;
    json["bound"] = figure.bound == TargetFigure::Bound::AtLeast ? "at least" : "at most";
    json["met"] = Json::array();
  }
  json["measured"] = Json::array();
  return json;
}

}  // namespace

Result<Json> measureTargets(PaperScenes& scenes, const TargetsOptions& options) {
  Json all = Json::array();
  for (const Case& one : kCases) {
    if (!options.only.empty() &&
        std::find(options.only.begin(), options.only.end(), one.name) == options.only.end())
      continue;
    const auto scene = one.load(scenes);
    if (!scene) return scene.error();
    Json entries = Json::array();
    for (std::uint64_t run = 0; run < options.runs; ++run) {
      const auto figures = one.measure(*scene, options.frameScale);
      if (!figures) return figures.error();
      for (std::size_t i = 0; i < figures->size(); ++i) {
        const TargetFigure& figure = (*figures)[i];
        if (run == 0) entries.push_back(figureJson(figure));
        entries[i]["measured"].push_back(figure.measured);
        if (figure.target) entries[i]["met"].push_back(figure.isMet());
      }
    }
    for (Json& entry : entries)
      all.push_back(std::move(entry));
  }
  return Json{{"runs", options.runs}, {"frame_scale", options.frameScale}, {"figures", std::move(all)}};
}

}  // namespace tessera::bench

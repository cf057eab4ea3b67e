#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "common/base/result.h"
#include "common/cull/culler.h"
#include "common/hierarchy/tile_cone.h"
#include "common/scene/load_scene.h"
#include "common/scene/scene.h"
#include "common/wall/camera_path.h"
#include "common/wall/wall.h"
#include "server/importer/scene_store.h"
#include "server/master/run_report.h"

namespace tessera {

/// The files that most commands take.
struct InputFiles {
  std::string wall, scene, camera, up = "auto", hierarchy = "graph";
  /// Instead of the wall file's own.
  std::optional<double> fovYDeg, near, far, scale;
  std::vector<double> eyeM;
  std::uint64_t maxTrianglesPerLeaf = 0;
  // The store of imported scenes.
  std::string store;
  std::uint64_t storeBudgetBytes = std::uint64_t{16} << 30, importMemoryBytes = 0;
  double importTimeoutS = 600;

  void addWall(CLI::App& app);
  void addScene(CLI::App& app);
  void addUp(CLI::App& app);
  /// --store and the limits of imports; addScene does it, too.
  void addStore(CLI::App& app);
  /// --hierarchy and --mtpl.
  void addHierarchy(CLI::App& app);
  void addCamera(CLI::App& app);

  [[nodiscard]] UpAxis upAxis() const;
  /// The flags over the file.
  [[nodiscard]] Status override(Wall& read) const;
  /// Reads and logs the warnings.
  [[nodiscard]] Result<Wall> readWall() const;
  /// From the store, imported before where need be, with a progress bar. Logs the warnings.
  [[nodiscard]] Result<OpenedScene> openScene() const;
  [[nodiscard]] Result<Scene> readScene() const;
  /// The shipped orbit where no file is named.
  [[nodiscard]] Result<CameraPath> readCamera() const;
};

/// How geometry goes to the tiles: --on-miss and the budgets.
struct StreamFlags {
  std::string onMiss = "wait";
  StreamOptions options;
  void add(CLI::App& app);
  [[nodiscard]] StreamOptions stream() const;
};

/// --algorithm, --bounds and the switches of the cullers.
struct CullFlags {
  std::string algorithm = "auto", bounds = "obb", planes = "corners", coherent = "measured";
  unsigned threads = 0;
  cull::Switches switches;
  /// "algorithm bounds" and the switches that are not at their defaults.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::vector<std::string> changedSwitches() const;
  void add(CLI::App& app);
  [[nodiscard]] Result<cull::Options> options() const;
  [[nodiscard]] PlaneSource planeSource() const {
    return planes == "matrix" ? PlaneSource::Matrix : PlaneSource::Corners;
  }
};

/// --animate and how.
struct MotionFlags {
  MotionOptions options;
  void add(CLI::App& app);
};

/// Writes into the report what the flags made of the scene and the culler.
void nameMode(RunReport& report, const InputFiles& files, const CullFlags& cull);

}  // namespace tessera

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/master/tile_roster.h"

namespace tessera {

/// Measured values of one kind, for percentiles.
struct Samples {
  std::vector<double> values;
  void add(double value) { values.push_back(value); }
  /// 0 <= p <= 100; 0 where there are none.
  [[nodiscard]] double percentile(double p) const;
  [[nodiscard]] double max() const { return percentile(100); }
};

/// What a run measured; interface of DIR/report.json. Times in milliseconds.
struct RunReport {
  std::string scene, wall, algorithm, bounds;
  std::uint64_t leaves = 0, triangles = 0, assets = 0, assetBytes = 0;
  std::uint64_t frames = 0;
  double seconds = 0;  ///< from the first frame to the last
  Samples updateMs, cullMs, encodeMs, sendMs, tileWaitMs, swapMs;
  Samples listBytesPerFrame, geometryBytesPerFrame, visibleLeavesPerFrame;
  Samples frameMs;            ///< from one swap to the next; of the first frame: from its start
  Samples trianglesPerFrame;  ///< of all tiles' lists
  double firstFrameMs =
      0;  ///< from the first frame's start until all tiles were ready: all geometry is sent then
  struct TileEntry {
    std::string name;
    TileCounts counts;
    Samples visibleLeaves;
    std::uint64_t listBytes = 0, geometryBytes = 0;
    std::uint64_t cacheHits = 0, cacheMisses = 0;
  };
  std::vector<TileEntry> tiles;
  Samples swapSkewUs;
  std::uint64_t pictures = 0, incompletePictures = 0;

  [[nodiscard]] std::string json() const;
  /// One line for each frame: {"frame", "ms", "pairs", "triangles"}.
  [[nodiscard]] std::string frameLog() const;
};

/// Adds the spread of the times at which tiles presented each frame, over frames that at least two tiles with
/// this machine's clock have shown.
void addSwapSkew(RunReport& report, const std::vector<std::vector<ShownTime>>& shownByTile);

}  // namespace tessera

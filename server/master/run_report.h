#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/master/motion_options.h"
#include "server/master/recorded.h"
#include "server/master/stream_options.h"
#include "server/master/tile_roster.h"

namespace tessera {

/// Measured values of one kind, for percentiles.
struct Samples : Recorded<double> {
  /// 0 <= p <= 100; 0 where there are none.
  [[nodiscard]] double percentile(double p) const;
  [[nodiscard]] double max() const { return percentile(100); }
};

/// What a run measured; interface of DIR/report.json. Times in milliseconds.
struct RunReport {
  std::string scene, wall, algorithm, bounds;
  std::string picked;  ///< the algorithm that culled the last frame: what "auto" has come to
  std::string hierarchy = "graph";
  std::uint64_t maxTrianglesPerLeaf = 0;  ///< 0: leaves as in the file
  std::vector<std::string> switches;      ///< of the culler, that are not at their defaults
  double warpErrorPx = 0;                 ///< TileSetups::warpErrorPx
  MotionOptions motion;
  std::uint64_t leaves = 0, triangles = 0, assets = 0, assetBytes = 0;
  std::uint64_t frames = 0;
  double seconds = 0;  ///< from the first frame to the last
  Samples updateMs, cullMs, encodeMs, sendMs, tileWaitMs, swapMs;
  Samples listBytesPerFrame, geometryBytesPerFrame, poseBytesPerFrame, visibleLeavesPerFrame;
  Samples masterMs;  ///< processor time of the frame loop's thread: update, cull, swap, encode and send
  Samples frameMs;   ///< from one swap to the next; of the first frame: from its start
  Samples trianglesPerFrame;  ///< of all tiles' lists
  double firstFrameMs =
      0;  ///< from the first frame's start until all tiles were ready: all geometry is sent then
  struct TileEntry {
    std::string name;
    TileCounts counts;
    Samples visibleLeaves;
    std::uint64_t listBytes = 0, geometryBytes = 0;
    std::uint64_t cacheHits = 0, cacheMisses = 0, cacheEvictions = 0;  ///< leaves
    std::uint64_t diskHits = 0;                                        ///< assets
    std::uint64_t predictedBytes = 0;                                  ///< sent ahead of need
  };
  std::vector<TileEntry> tiles;
  Samples swapSkewUs;
  StreamOptions stream;
  std::uint64_t framesIncomplete = 0;  ///< at least one tile could not draw all of its list
  std::uint64_t pictures = 0, incompletePictures = 0;

  /// Makes room for what each of `count` frames adds, so that the frame loop need not.
  void expect(std::size_t count);
  /// Keeps what each frame adds of the last `count` alone; percentiles are of these. For runs without
  /// an end, whose memory must not grow.
  void keepLast(std::size_t count);

  [[nodiscard]] std::string json() const;
  /// One line for each frame: {"frame", "ms", "pairs", "list_bytes", "geometry_bytes", "triangles"}.
  [[nodiscard]] std::string frameLog() const;

 private:
  template <class Visit>
  void forEachSamples(Visit visit);
};

/// Adds the spread of the times at which tiles presented each frame, over frames that at least two tiles with
/// this machine's clock have shown.
void addSwapSkew(RunReport& report, const std::vector<std::vector<ShownTime>>& shownByTile);

}  // namespace tessera

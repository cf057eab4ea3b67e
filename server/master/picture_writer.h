#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/result.h"
#include "common/image/mosaic.h"
#include "common/wall/wall.h"
#include "common/wall/wall_picture.h"
#include "proto/messages.h"

namespace tessera {

/// Stitches the tiles' pictures of a frame as wallPicture lays them out and writes them as
/// DIR/frame-NNNNNN.png in a thread of its own. Thread-safe. At most a few frames wait in memory: complete()
/// holds the caller back when the disk is slower.
class PictureWriter {
 public:
  /// Of frames 1, 1 + every, 1 + 2 * every, ...
  PictureWriter(const Wall& wall, std::filesystem::path folder, std::uint64_t every);
  ~PictureWriter();
  PictureWriter(const PictureWriter&) = delete;
  PictureWriter& operator=(const PictureWriter&) = delete;

  [[nodiscard]] bool wants(std::uint64_t frame) const { return (frame - 1) % every_ == 0; }
  /// A tile's part of a frame. False: it has not the tile's size.
  [[nodiscard]] bool add(std::uint32_t tile, std::uint64_t frame, const proto::Picture& picture);
  /// No more parts come for frames up to `frame`: they are written as they are, black where a tile is
  /// missing.
  void complete(std::uint64_t frame);
  /// Writes what is left and ends the thread. The first failure of the run, if any.
  [[nodiscard]] Status finish();

  [[nodiscard]] std::uint64_t written() const;
  /// Frames in which some tile's picture was missing.
  [[nodiscard]] std::uint64_t incomplete() const;
  [[nodiscard]] std::filesystem::path pathOf(std::uint64_t frame) const;

 private:
  struct Stitched {
    Mosaic picture;
    std::uint32_t parts = 0;
  };
  void writeAll();

  const std::vector<Tile> tiles_;
  const WallPicture layout_;
  const std::filesystem::path folder_;
  const std::uint64_t every_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::uint64_t, Stitched> open_;
  std::deque<std::pair<std::uint64_t, Mosaic>> queue_;
  std::uint64_t written_ = 0, incomplete_ = 0;
  bool done_ = false;
  std::optional<Error> failure_;
  std::thread thread_;
};

}  // namespace tessera

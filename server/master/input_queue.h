#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "proto/messages.h"

namespace tessera {

/// What a person did at one tile's window.
struct TileInput {
  std::uint32_t tile = 0;  ///< index into the wall's tiles
  proto::Input input;
};

/// What people did at the tiles' windows since the frame loop asked last, in order of arrival. Thread-safe;
/// allocates nothing once made.
///
/// Bounded: moves, turns of the wheel and states of a gamepad that follow each other from the same tile are
/// one. When it is full the oldest move makes room, or else the oldest of anything but Quit.
class InputQueue {
 public:
  static constexpr std::size_t kCapacity = 256;

  InputQueue();

  void add(std::uint32_t tile, const proto::Input& input);

  /// Moves everything to `inputs`, whose old content is lost.
  void drainInto(std::vector<TileInput>& inputs);

 private:
  bool mergeIntoLast(std::uint32_t tile, const proto::Input& input);
  void makeRoom();

  std::mutex mutex_;
  std::vector<TileInput> waiting_;
};

}  // namespace tessera

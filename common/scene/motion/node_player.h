#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/motion/motion.h"

namespace tessera::motion {

/// Where the nodes of a glTF scene are at a time. What no channel reaches is computed once. `motion` must
/// outlive it.
class NodePlayer {
 public:
  explicit NodePlayer(const Motion& motion);

  /// Any time, in any order; in seconds from the start.
  void advance(double timeS);

  /// From the node's coordinates to the world's.
  [[nodiscard]] const Mat4& world(std::uint32_t node) const { return worlds_[node]; }
  [[nodiscard]] std::span<const float> weights(std::uint32_t node) const { return weights_[node]; }

 private:
  void place(std::uint32_t node);

  const Motion* motion_;
  std::vector<Trs> trs_;  ///< by node, now
  std::vector<Mat4> worlds_;
  std::vector<std::vector<float>> weights_;
  std::vector<std::uint32_t> moving_;  ///< ascending: a parent comes before its children
  std::vector<double> value_;
};

}  // namespace tessera::motion

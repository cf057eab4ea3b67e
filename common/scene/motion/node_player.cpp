#include "common/scene/motion/node_player.h"

#include <algorithm>

#include "common/scene/motion/channel.h"

namespace tessera::motion {

NodePlayer::NodePlayer(const Motion& motion) : motion_(&motion) {
  const auto count = static_cast<std::uint32_t>(motion.nodes.size());
  std::vector<bool> isMoving(count, false);
  std::size_t widest = 4;
  for (const Channel& channel : motion.channels) {
    if (channel.path != Path::Weights) isMoving[channel.node] = true;
    widest = std::max<std::size_t>(widest, channel.width);
  }
  value_.resize(widest);
  trs_.reserve(count);
  worlds_.resize(count, Mat4::Identity());
  for (std::uint32_t node = 0; node < count; ++node) {
    const Node& source = motion.nodes[node];
    trs_.push_back(source.trs);
    weights_.push_back(source.weights);
    if (source.parent != kNone && isMoving[source.parent]) isMoving[node] = true;
    if (isMoving[node]) moving_.push_back(node);
    place(node);
  }
}

void NodePlayer::place(std::uint32_t node) {
  const Node& source = motion_->nodes[node];
  const Mat4 local = source.hasMatrix ? source.matrix : matrixOf(trs_[node]);
  worlds_[node] = source.parent == kNone ? local : worlds_[source.parent] * local;
}

void NodePlayer::advance(double timeS) {
  for (const Channel& channel : motion_->channels) {
    sample(channel, timeS, value_);
    Trs& trs = trs_[channel.node];
    switch (channel.path) {
      case Path::Translation:
        trs.translation = {value_[0], value_[1], value_[2]};
        break;
      case Path::Rotation:
        std::copy_n(value_.begin(), 4, trs.rotation.begin());
        break;
      case Path::Scale:
        trs.scale = {value_[0], value_[1], value_[2]};
        break;
      case Path::Weights:
        std::transform(value_.begin(), value_.begin() + channel.width, weights_[channel.node].begin(),
                       [](double weight) { return static_cast<float>(weight); });
        break;
    }
  }
  for (const std::uint32_t node : moving_)
    place(node);
}

}  // namespace tessera::motion

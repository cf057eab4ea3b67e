#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/net/connection.h"
#include "common/scene/scene.h"
#include "common/wall/wall.h"
#include "proto/codec.h"
#include "proto/list_coder.h"
#include "server/master/scene_motion.h"

namespace tessera {

/// Bytes sent to one tile, counted where the messages are made.
struct TileTraffic {
  std::atomic<std::uint64_t> listBytes{0}, geometryBytes{0};
};

/// What all tiles show beside or instead of the scene.
struct Display {
  bool overlay = false;
  proto::Pattern pattern = proto::Pattern::None;
  friend bool operator==(const Display&, const Display&) = default;
};

/// What one tile has: which assets and leaf records it was sent, and which frame's list it acknowledged last.
/// The connection keeps the order of messages, so whatever was queued before a frame is there when the frame
/// is. Used by the frame loop alone. `scene` outlives it and every message still queued.
///
/// A tile that acknowledged the frame before is told what toggled since. One that has not (it fell behind, or
/// has just come) is sent the whole list, against the empty one: that happens rarely, and no earlier list
/// need be kept here.
class TileMirror {
 public:
  explicit TileMirror(const Scene& scene)
      : scene_(&scene),
        knownLeaves_(scene.leaves.size(), false),
        knownAssets_(scene.assets.size(), false),
        list_(static_cast<std::uint32_t>(scene.leaves.size())) {}

  /// Forgets everything when another process has taken the tile.
  void follow(std::uint64_t session);
  /// The tile said Ready to `frame`.
  void acknowledge(std::uint64_t frame);

  struct FrameOrder {
    std::uint64_t frame = 0;
    Frustum frustum = {};  ///< drawnFrustum of this tile, near and far given
    ImageAxes axes = {};   ///< drawnAxes
    /// Leaves that come or go, against the list of `baseFrame` (0: the empty list).
    const VisibleList* toggled = nullptr;
    std::uint64_t baseFrame = 0;
    std::uint32_t leafCount = 0;  ///< of the list now
    bool wantPicture = false;
    /// In stereo: `frustum` is the left eye's, and this, drawn likewise, the right one's.
    std::optional<proto::RightEye> rightEye = {};
    proto::StereoLayout stereo = proto::StereoLayout::None;
    const SceneMotion* motion = nullptr;  ///< null: nothing moves
    Display display = {};
    std::uint32_t skewUs = 0;
  };
  struct Sent {
    std::uint64_t listBytes = 0;   ///< the frame message
    std::uint64_t assetBytes = 0;  ///< assets ordered for it
    std::uint64_t poseBytes = 0;
    std::uint32_t assets = 0, leaves = 0;
    std::uint32_t hits = 0;  ///< leaves that came into view and were known already
  };
  /// Whether the tile's last list is that of the frame before, so that what toggled since is all it needs.
  [[nodiscard]] bool keepsUpWith(std::uint64_t frame) const {
    return baseFrame_ != 0 && baseFrame_ + 1 == frame;
  }
  /// Queues what the tile lacks for the frame, then the frame; who wakes the connection's writer is the
  /// caller's business. Does not allocate where nothing is lacking, once warm.
  Sent send(net::Connection& connection, proto::Encoder& encoder, const FrameOrder& order);

  [[nodiscard]] const TileTraffic& traffic() const { return *traffic_; }

 private:
  void needAsset(std::uint32_t number, Sent& sent);
  void sendGeometry(net::Connection& connection, const VisibleList& toggled, Sent& sent);
  void sendPoses(net::Connection& connection, const SceneMotion& motion, std::uint64_t frame, Sent& sent);

  const Scene* scene_;
  std::shared_ptr<TileTraffic> traffic_ = std::make_shared<TileTraffic>();
  std::uint64_t session_ = 0;
  std::vector<bool> knownLeaves_, knownAssets_;
  std::uint64_t baseFrame_ = 0, pendingFrame_ = 0;
  std::uint32_t baseLeafCount_ = 0, pendingLeafCount_ = 0;
  proto::ListEncoder list_;  ///< as of the frame that was sent last
  std::vector<std::byte> delta_;
  std::vector<std::uint32_t> missingAssets_, missingLeaves_;
  std::uint64_t posesFrame_ = 0;  ///< the last one that poses were sent for
  std::vector<std::uint32_t> posed_;
};

}  // namespace tessera

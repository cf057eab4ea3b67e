#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/assets/leaf_cache.h"
#include "common/net/connection.h"
#include "common/scene/scene.h"
#include "common/wall/wall.h"
#include "proto/codec.h"
#include "proto/list_coder.h"
#include "server/master/scene_motion.h"
#include "server/master/stream_options.h"

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

/// What one tile has: which assets and leaf records it was sent and still keeps (LeafCache: the tile decides
/// alike), and which frame's list it acknowledged last. The connection keeps the order of messages, so
/// whatever was queued before a frame is there when the frame is. Used by the frame loop alone. `scene`
/// outlives it and every message still queued.
///
/// A leaf that comes into view has its record sent at once and its assets by need: larger on the screen
/// first. Where the wall does not wait for them, as many a frame as the upload budget allows; the tile draws
/// what stands for the others. What is left of the budget goes to leaves that were predicted. What does not
/// fit into the tile's cache beside what the list needs already is not sent at all.
///
/// A tile that acknowledged the frame before is told what toggled since. One that has not (it fell behind, or
/// has just come) is sent the whole list, against the empty one.
class TileMirror {
 public:
  TileMirror(const Scene& scene, const StreamOptions& options);

  /// Forgets everything when another process has taken the tile.
  void follow(std::uint64_t session, const TileFacts& facts);
  /// The tile said Ready to `frame`.
  void acknowledge(std::uint64_t frame);
  /// The tile does not have these after all, by number: they are sent once more, at most once a second each.
  void resend(std::span<const std::uint32_t> assets);

  struct FrameOrder {
    std::uint64_t frame = 0;
    Frustum frustum = {};  ///< drawnFrustum of this tile, near and far given
    ImageAxes axes = {};   ///< drawnAxes
    /// Leaves that come or go, against the list of `baseFrame` (0: the empty list).
    const VisibleList* toggled = nullptr;
    std::uint64_t baseFrame = 0;
    std::uint32_t leafCount = 0;             ///< of the list now
    const VisibleList* predicted = nullptr;  ///< leaves that will probably be needed; null: nothing is known
    bool wantPicture = false;
    /// In stereo: `frustum` is the left eye's, and this, drawn likewise, the right one's.
    std::optional<proto::RightEye> rightEye = {};
    proto::StereoLayout stereo = proto::StereoLayout::None;
    const SceneMotion* motion = nullptr;  ///< null: nothing moves
    Display display = {};
    std::uint32_t skewUs = 0;
  };
  struct Sent {
    std::uint64_t listBytes = 0;       ///< the frame message, and what is to be kept
    std::uint64_t assetBytes = 0;      ///< assets ordered for it
    std::uint64_t predictedBytes = 0;  ///< of these, ahead of need
    std::uint64_t poseBytes = 0;
    std::uint32_t assets = 0, leaves = 0;
    std::uint32_t hits = 0, misses = 0;  ///< leaves that came into view and were there, or not
    std::uint32_t diskHits = 0;          ///< assets that the tile has on its disk
    std::uint32_t evictions = 0;         ///< leaves
    std::uint32_t incomplete = 0;        ///< leaves in the list that are not all there with this frame
    bool isCacheTooSmall = false;        ///< some of them never fit beside the others
  };
  /// Whether the tile's last list is that of the frame before, so that what toggled since is all it needs.
  [[nodiscard]] bool keepsUpWith(std::uint64_t frame) const {
    return baseFrame_ != 0 && baseFrame_ + 1 == frame;
  }
  /// Queues what the tile is to have with the frame, then the frame; who wakes the connection's writer is the
  /// caller's business. Does not allocate where nothing is lacking, once warm.
  Sent send(net::Connection& connection, proto::Encoder& encoder, const FrameOrder& order);

  [[nodiscard]] const TileTraffic& traffic() const { return *traffic_; }

 private:
  enum class Fit { Sent, NotNow, Never };
  /// What may still be sent with this frame.
  struct Room {
    std::uint64_t uploadBytes = 0;
    bool isBounded = true;
    std::uint64_t cacheBytes = 0;
  };

  void sortByNeed(std::vector<std::uint32_t>& leaves, const Vec3& eye);
  void noteComing(const VisibleList& toggled, Sent& sent);
  void addRecord(std::uint32_t leaf);
  void addMissing(std::uint32_t asset);
  Fit sendAssetsOf(std::uint32_t leaf, Room& room, Sent& sent);
  void completeWhatIsSeen(const FrameOrder& order, Room& room, Sent& sent);
  void sendAhead(const FrameOrder& order, Room& room, Sent& sent);
  void sendKeep(net::Connection& connection, const VisibleList& predicted, Sent& sent);
  void queueGeometry(net::Connection& connection, Sent& sent);
  void sendPoses(net::Connection& connection, const SceneMotion& motion, std::uint64_t frame, Sent& sent);
  void sendFrame(net::Connection& connection, proto::Encoder& encoder, const FrameOrder& order, Sent& sent);

  const Scene* scene_;
  StreamOptions options_;
  std::shared_ptr<TileTraffic> traffic_ = std::make_shared<TileTraffic>();
  std::uint64_t session_ = 0;
  LeafCache cache_;
  std::vector<bool> complete_;  ///< by leaf: its record and all its assets are with the tile
  std::vector<bool> onDisk_;
  std::vector<std::uint32_t> incomplete_;  ///< in the list and not complete
  std::uint64_t baseFrame_ = 0, pendingFrame_ = 0;
  proto::ListEncoder list_;  ///< as of the frame that was sent last
  std::uint64_t listLeafCount_ = 0;
  VisibleList changed_, kept_;
  std::vector<AssetId> needs_;
  std::vector<std::byte> delta_;
  std::vector<std::uint32_t> newRecords_, newAssets_, group_, candidates_;
  std::vector<std::pair<double, std::uint32_t>> ranked_;
  std::uint64_t posesFrame_ = 0;  ///< the last one that poses were sent for
  std::vector<std::uint32_t> posed_;
  std::uint64_t aheadBytes_ = 0;  ///< sent ahead in the current stretch of frames
  std::uint64_t stretchFrame_ = 0, keepTurn_ = 0;
  std::unordered_map<std::uint32_t, std::chrono::steady_clock::time_point> resent_;
  std::vector<std::uint32_t> toResend_;
};

}  // namespace tessera

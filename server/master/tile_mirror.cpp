#include "server/master/tile_mirror.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

namespace tessera {

namespace {

static_assert(kMaxAssetBytes <= proto::kMaxAssetBytes);

constexpr std::size_t kAssetBatchBytes = 4 << 20;
constexpr std::size_t kLeafBatch = 4096;
constexpr std::size_t kMostPoseFloats = 1 << 20;

proto::Bytes encodeAssets(const AssetTable& assets, const std::vector<std::uint32_t>& chosen) {
  proto::Assets message;
  std::vector<AssetBytes> held;
  message.assets.reserve(chosen.size());
  for (const std::uint32_t number : chosen) {
    const auto bytes = assets.read(number);
    if (!bytes) {
      spdlog::error("{}", bytes.error().text());
      continue;
    }
    const AssetRow& row = assets.row(number);
    held.push_back(*bytes);
    message.assets.push_back({.id = row.id.bytes,
                              .kind = static_cast<proto::AssetKind>(row.kind),
                              .bytes = std::as_bytes(std::span(**bytes))});
  }
  return proto::encode(message);
}

proto::LeafRecord recordOf(const Scene& scene, std::uint32_t leaf) {
  const SceneLeaf& from = scene.leaves[leaf];
  const Sphere& sphere = scene.hierarchy.sphere(scene.hierarchy.nodeOfLeaf(leaf));
  proto::LeafRecord record;
  record.id = leaf;
  record.drawable = scene.assets.row(from.drawable).id.bytes;
  record.state = scene.assets.row(from.state).id.bytes;
  record.localToWorld = from.localToWorld;
  record.center = sphere.center;
  record.radius = sphere.radius;
  if (const Billboard* billboard = scene.billboardOf(from)) {
    record.billboard = proto::LeafBillboard{static_cast<proto::BillboardMode>(billboard->mode),
                                            billboard->axis, billboard->normal, billboard->position};
  }
  return record;
}

proto::Bytes encodeLeaves(const Scene& scene, const std::vector<std::uint32_t>& leaves) {
  proto::Leaves message;
  message.leaves.reserve(leaves.size());
  for (const std::uint32_t leaf : leaves)
    message.leaves.push_back(recordOf(scene, leaf));
  return proto::encode(message);
}

/// Queues a geometry message that is made only when it is its turn.
template <class Make>
void sendLazily(net::Connection& connection, const std::shared_ptr<TileTraffic>& traffic, Make make) {
  connection.queue([traffic, make = std::move(make)] {
    auto bytes = std::make_shared<const proto::Bytes>(make());
    traffic->geometryBytes += bytes->size();
    return bytes;
  });
}

}  // namespace

void TileMirror::follow(std::uint64_t session) {
  if (session == session_) return;
  session_ = session;
  knownLeaves_.assign(knownLeaves_.size(), false);
  knownAssets_.assign(knownAssets_.size(), false);
  baseFrame_ = pendingFrame_ = posesFrame_ = 0;
  baseLeafCount_ = pendingLeafCount_ = 0;
}

void TileMirror::acknowledge(std::uint64_t frame) {
  if (frame == 0 || frame != pendingFrame_) return;
  baseFrame_ = frame;
  baseLeafCount_ = pendingLeafCount_;
  pendingFrame_ = 0;
}

TileMirror::Sent TileMirror::send(net::Connection& connection, proto::Encoder& encoder,
                                  const FrameOrder& order) {
  Sent sent;
  sendGeometry(connection, *order.toggled, sent);
  if (order.motion) sendPoses(connection, *order.motion, order.frame, sent);
  // Of the leaves that toggled, those that came outnumber those that went by what the list has grown.
  const std::uint64_t had = order.baseFrame == 0 ? 0 : baseLeafCount_;
  const std::uint64_t came = (leafCount(*order.toggled) + order.leafCount - had) / 2;
  sent.hits = static_cast<std::uint32_t>(came) - sent.leaves;
  if (order.baseFrame == 0) list_.reset();
  list_.encode(*order.toggled, delta_);

  proto::Frame message;
  message.frame = order.frame;
  message.baseFrame = order.baseFrame;
  message.eye = order.frustum.eye;
  message.corners = order.frustum.corners;
  message.nearM = order.frustum.near.value();
  message.farM = order.frustum.far.value();
  message.right = order.axes.right;
  message.up = order.axes.up;
  message.toggles = delta_;
  message.listLeafCount = order.leafCount;
  message.wantPicture = order.wantPicture;
  message.overlay = order.display.overlay;
  message.pattern = order.display.pattern;
  message.skewUs = order.skewUs;
  message.rightEye = order.rightEye;
  message.stereo = order.stereo;
  const std::span<const std::byte> bytes = encoder.encode(message);
  sent.listBytes = bytes.size();
  traffic_->listBytes += bytes.size();
  connection.queue(bytes);

  pendingFrame_ = order.frame;
  pendingLeafCount_ = order.leafCount;
  return sent;
}

void TileMirror::needAsset(std::uint32_t number, Sent& sent) {
  if (knownAssets_[number]) return;
  knownAssets_[number] = true;
  for (const std::uint32_t needed : scene_->assets.needsOf(number))
    needAsset(needed, sent);
  missingAssets_.push_back(number);
  sent.assetBytes += scene_->assets.row(number).bytes;
  ++sent.assets;
}

void TileMirror::sendGeometry(net::Connection& connection, const VisibleList& toggled, Sent& sent) {
  missingAssets_.clear();
  missingLeaves_.clear();
  // What goes out of view is known, and so is most of what comes.
  forEachLeaf(toggled, [&](std::uint32_t leaf) {
    if (knownLeaves_[leaf]) return;
    knownLeaves_[leaf] = true;
    missingLeaves_.push_back(leaf);
    needAsset(scene_->leaves[leaf].state, sent);
    needAsset(scene_->leaves[leaf].drawable, sent);
  });
  sent.leaves = static_cast<std::uint32_t>(missingLeaves_.size());
  if (missingLeaves_.empty()) return;

  std::vector<std::uint32_t> batch;
  std::size_t batchBytes = 0;
  const auto flush = [&] {
    if (batch.empty()) return;
    sendLazily(connection, traffic_, [assets = &scene_->assets, chosen = std::exchange(batch, {})] {
      return encodeAssets(*assets, chosen);
    });
    batchBytes = 0;
  };
  for (const std::uint32_t number : missingAssets_) {
    const std::size_t bytes = scene_->assets.row(number).bytes;
    if (batchBytes + bytes > kAssetBatchBytes || batch.size() == proto::kMaxAssetsPerMessage) flush();
    batch.push_back(number);
    batchBytes += bytes;
  }
  flush();
  for (std::size_t first = 0; first < missingLeaves_.size(); first += kLeafBatch) {
    const auto begin = missingLeaves_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto count = static_cast<std::ptrdiff_t>(std::min(kLeafBatch, missingLeaves_.size() - first));
    sendLazily(connection, traffic_,
               [scene = scene_, leaves = std::vector<std::uint32_t>(begin, begin + count)] {
                 return encodeLeaves(*scene, leaves);
               });
  }
}

/// Records tell where leaves were when the scene was loaded, so that those just sent need their pose, too;
/// and a tile that missed frames missed the poses that came with them.
void TileMirror::sendPoses(net::Connection& connection, const SceneMotion& motion, std::uint64_t frame,
                           Sent& sent) {
  const bool keptUp = posesFrame_ != 0 && posesFrame_ + 1 == frame;
  posesFrame_ = frame;
  posed_.clear();
  for (const std::uint32_t leaf : keptUp ? motion.moved() : motion.posed()) {
    if (knownLeaves_[leaf]) posed_.push_back(leaf);
  }
  for (const std::uint32_t leaf : missingLeaves_) {
    if (motion.hasPose(leaf)) posed_.push_back(leaf);
  }
  std::sort(posed_.begin(), posed_.end());
  posed_.erase(std::unique(posed_.begin(), posed_.end()), posed_.end());
  proto::Poses message;
  std::size_t floats = 0;
  const auto flush = [&] {
    if (message.poses.empty()) return;
    const proto::Bytes bytes = proto::encode(message);
    sent.poseBytes += bytes.size();
    connection.queue(std::span<const std::byte>(bytes));
    message.poses.clear();
    floats = 0;
  };
  for (const std::uint32_t leaf : posed_) {
    message.poses.push_back(motion.poseOf(leaf));
    floats += message.poses.back().joints.size() + message.poses.back().weights.size();
    if (message.poses.size() == kLeafBatch || floats > kMostPoseFloats) flush();
  }
  flush();
}

}  // namespace tessera

#include "server/master/tile_mirror.h"

#include <algorithm>
#include <utility>

#include "proto/list_codec.h"

namespace tessera {

namespace {

static_assert(kMaxAssetBytes <= proto::kMaxAssetBytes);

constexpr std::size_t kAssetBatchBytes = 4 << 20;
constexpr std::size_t kLeafBatch = 4096;

proto::Bytes encodeAssets(const Scene& scene, const std::vector<AssetId>& ids) {
  proto::Assets message;
  for (const AssetId& id : ids) {
    const Asset* asset = scene.assets.find(id);
    message.assets.push_back({.id = id.bytes,
                              .kind = static_cast<proto::AssetKind>(asset->kind),
                              .bytes = std::as_bytes(std::span(asset->bytes))});
  }
  return proto::encode(message);
}

proto::LeafRecord recordOf(const Scene& scene, std::uint32_t leaf) {
  const SceneLeaf& from = scene.leaves[leaf];
  const Sphere& sphere = scene.hierarchy.sphere(scene.hierarchy.nodeOfLeaf(leaf));
  proto::LeafRecord record;
  record.id = leaf;
  record.drawable = from.drawable.bytes;
  record.state = from.state.bytes;
  record.localToWorld = from.localToWorld;
  record.center = sphere.center;
  record.radius = sphere.radius;
  if (from.billboard) {
    record.billboard =
        proto::LeafBillboard{static_cast<proto::BillboardMode>(from.billboard->mode), from.billboard->axis,
                             from.billboard->normal, from.billboard->position};
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
  knownAssets_.clear();
  baseFrame_ = pendingFrame_ = 0;
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
  // Of the leaves that toggled, those that came outnumber those that went by what the list has grown.
  const std::uint64_t had = order.baseFrame == 0 ? 0 : baseLeafCount_;
  const std::uint64_t came = (leafCount(*order.toggled) + order.leafCount - had) / 2;
  sent.hits = static_cast<std::uint32_t>(came) - sent.leaves;
  proto::encodeToggles(*order.toggled, delta_);

  proto::Frame message;
  message.frame = order.frame;
  message.baseFrame = order.baseFrame;
  message.eye = order.frustum->eye;
  message.corners = order.frustum->corners;
  message.nearM = order.frustum->near.value();
  message.farM = order.frustum->far.value();
  message.right = order.view->right;
  message.up = order.view->up;
  message.toggles = delta_;
  message.listLeafCount = order.leafCount;
  message.wantPicture = order.wantPicture;
  const std::span<const std::byte> bytes = encoder.encode(message);
  sent.listBytes = bytes.size();
  traffic_->listBytes += bytes.size();
  connection.queue(bytes);

  pendingFrame_ = order.frame;
  pendingLeafCount_ = order.leafCount;
  return sent;
}

void TileMirror::needAsset(const AssetId& id, Sent& sent) {
  if (!knownAssets_.insert(id).second) return;
  const Asset* asset = scene_->assets.find(id);
  for (const AssetId& needed : asset->needs)
    needAsset(needed, sent);
  missingAssets_.push_back(id);
  sent.assetBytes += asset->bytes.size();
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

  std::vector<AssetId> batch;
  std::size_t batchBytes = 0;
  const auto flush = [&] {
    if (batch.empty()) return;
    sendLazily(connection, traffic_,
               [scene = scene_, ids = std::exchange(batch, {})] { return encodeAssets(*scene, ids); });
    batchBytes = 0;
  };
  for (const AssetId& id : missingAssets_) {
    const std::size_t bytes = scene_->assets.find(id)->bytes.size();
    if (batchBytes + bytes > kAssetBatchBytes || batch.size() == proto::kMaxAssetsPerMessage) flush();
    batch.push_back(id);
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

}  // namespace tessera

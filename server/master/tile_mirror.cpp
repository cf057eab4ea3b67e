#include "server/master/tile_mirror.h"

#include <algorithm>
#include <utility>

#include "proto/codec.h"
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
  connection.send([traffic, make = std::move(make)] {
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
  baseList_.clear();
  pendingList_.clear();
}

void TileMirror::acknowledge(std::uint64_t frame) {
  if (frame == 0 || frame != pendingFrame_) return;
  baseFrame_ = frame;
  std::swap(baseList_, pendingList_);
  pendingFrame_ = 0;
}

TileMirror::Sent TileMirror::send(net::Connection& connection, const FrameOrder& order) {
  Sent sent;
  sendGeometry(connection, differenceOf(*order.list, baseList_), sent);
  proto::encodeListDelta(baseList_, *order.list, delta_);

  proto::Frame message;
  message.frame = order.frame;
  message.baseFrame = baseFrame_;
  message.eye = order.frustum->eye;
  message.corners = order.frustum->corners;
  message.nearM = order.frustum->near.value();
  message.farM = order.frustum->far.value();
  message.right = order.view->right;
  message.up = order.view->up;
  message.toggles = delta_;
  message.listLeafCount = static_cast<std::uint32_t>(leafCount(*order.list));
  message.wantPicture = order.wantPicture;
  proto::Bytes bytes = proto::encode(message);
  sent.listBytes = bytes.size();
  traffic_->listBytes += bytes.size();
  connection.send(std::move(bytes));

  pendingFrame_ = order.frame;
  pendingList_ = *order.list;
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

void TileMirror::sendGeometry(net::Connection& connection, const VisibleList& entering, Sent& sent) {
  missingAssets_.clear();
  missingLeaves_.clear();
  forEachLeaf(entering, [&](std::uint32_t leaf) {
    if (knownLeaves_[leaf]) {
      ++sent.hits;
      return;
    }
    knownLeaves_[leaf] = true;
    missingLeaves_.push_back(leaf);
    needAsset(scene_->leaves[leaf].state, sent);
    needAsset(scene_->leaves[leaf].drawable, sent);
  });
  sent.leaves = static_cast<std::uint32_t>(missingLeaves_.size());

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

#include "server/master/tile_mirror.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "proto/list_codec.h"

namespace tessera {

namespace {

static_assert(kMaxAssetBytes <= proto::kMaxAssetBytes);

// A message is in memory while it is written, one for each tile.
constexpr std::size_t kAssetBatchBytes = 1 << 20;
constexpr std::size_t kLeafBatch = 4096;
constexpr std::size_t kMostAssetsInBatch = 4096;
// Of predicted leaves that a frame looks at: bounds the time it takes.
constexpr std::size_t kMostCandidates = 512;
constexpr std::chrono::seconds kResendPause{1};
constexpr std::uint64_t kKeepEvery = 8;  // frames
constexpr std::size_t kMostPoseFloats = 1 << 20;

/// An asset of an order: by number, and whether the tile has it on its disk.
struct OrderedAsset {
  std::uint32_t number = 0;
  bool isOnDisk = false;
};

proto::Bytes encodeAssets(const AssetTable& assets, const std::vector<OrderedAsset>& chosen) {
  proto::Assets message;
  std::vector<AssetBytes> held;
  message.assets.reserve(chosen.size());
  for (const OrderedAsset& ordered : chosen) {
    const AssetRow& row = assets.row(ordered.number);
    proto::Asset& asset = message.assets.emplace_back();
    asset.id = row.id.bytes;
    asset.kind = static_cast<proto::AssetKind>(row.kind);
    for (const std::uint32_t needed : assets.needsOf(ordered.number))
      asset.needs.push_back(assets.row(needed).id.bytes);
    asset.diskBytes = row.bytes;
    if (ordered.isOnDisk) continue;
    const auto bytes = assets.read(ordered.number);
    if (!bytes) {
      // The tile will find that it is not on its disk either, and say so: then it is tried again.
      spdlog::error("{}", bytes.error().text());
      continue;
    }
    held.push_back(*bytes);
    asset.diskBytes = 0;
    asset.bytes = std::as_bytes(std::span(**bytes));
  }
  return proto::encode(message);
}

proto::LeafRecord recordOf(const Scene& scene, std::uint32_t leaf) {
  const SceneLeaf& from = scene.leaves[leaf];
  const std::uint32_t node = scene.hierarchy.nodeOfLeaf(leaf);
  const Sphere& sphere = scene.hierarchy.sphere(node);
  const Obb& box = scene.hierarchy.obb(node);
  proto::LeafRecord record;
  record.id = leaf;
  record.drawable = scene.assets.row(from.drawable).id.bytes;
  record.state = scene.assets.row(from.state).id.bytes;
  record.localToWorld = from.localToWorld;
  record.center = box.center;
  record.radius = sphere.radius + (sphere.center - box.center).norm();
  record.halfAxes = box.halfAxes;
  for (std::size_t i = 0; i < 3; ++i)
    record.meanRgb[i] = static_cast<float>(from.meanRgba[i]) / 255;
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

TileMirror::TileMirror(const Scene& scene, const StreamOptions& options)
    : scene_(&scene),
      options_(options),
      complete_(scene.leaves.size(), false),
      list_(static_cast<std::uint32_t>(scene.leaves.size())) {}

void TileMirror::follow(std::uint64_t session, const TileFacts& facts) {
  if (session == session_) return;
  session_ = session;
  cache_.clear();
  cache_.setBudget(facts.cacheBytes > 0 ? facts.cacheBytes : LeafCache::kNoBudget);
  complete_.assign(complete_.size(), false);
  onDisk_ = facts.onDisk;
  onDisk_.resize(scene_->assets.size(), false);
  incomplete_.clear();
  toResend_.clear();
  resent_.clear();
  list_.reset();
  baseFrame_ = pendingFrame_ = posesFrame_ = 0;
}

void TileMirror::acknowledge(std::uint64_t frame) {
  if (frame == 0 || frame != pendingFrame_) return;
  baseFrame_ = frame;
  pendingFrame_ = 0;
}

void TileMirror::resend(std::span<const std::uint32_t> assets) {
  const auto now = std::chrono::steady_clock::now();
  for (const std::uint32_t asset : assets) {
    onDisk_[asset] = false;
    if (!cache_.hasAsset(scene_->assets.row(asset).id)) continue;
    const auto [last, isFirst] = resent_.try_emplace(asset, now);
    if (!isFirst && now - last->second < kResendPause) continue;
    last->second = now;
    toResend_.push_back(asset);
  }
}

TileMirror::Sent TileMirror::send(net::Connection& connection, proto::Encoder& encoder,
                                  const FrameOrder& order) {
  Sent sent;
  newRecords_.clear();
  newAssets_.clear();
  std::swap(newAssets_, toResend_);
  // A whole list says nothing of what the one before had: the books need the difference.
  const VisibleList* changed = order.toggled;
  if (order.baseFrame == 0) {
    symmetricDifferenceInto(list_.list(), *order.toggled, changed_);
    changed = &changed_;
  }
  noteComing(*changed, sent);
  Room room{.uploadBytes = options_.uploadBytes,
            .isBounded = options_.onMiss != proto::OnMiss::Wait,
            .cacheBytes = cache_.budgetBytes() - std::min(cache_.shownBytes(), cache_.budgetBytes())};
  completeWhatIsSeen(order, room, sent);
  room.isBounded = true;
  if (order.predicted) sendAhead(order, room, sent);
  queueGeometry(connection, sent);
  if (order.predicted) sendKeep(connection, *order.predicted, sent);
  if (order.motion) sendPoses(connection, *order.motion, order.frame, sent);
  sendFrame(connection, encoder, order, sent);
  cache_.show(*changed);
  const LeafCache::Dropped& dropped = cache_.trim();
  for (const std::uint32_t leaf : dropped.leaves)
    complete_[leaf] = false;
  sent.evictions = static_cast<std::uint32_t>(dropped.leaves.size());
  sent.incomplete = static_cast<std::uint32_t>(incomplete_.size());
  return sent;
}

/// Leaves that come into view without being all there get a record, and wait for their assets.
void TileMirror::noteComing(const VisibleList& toggled, Sent& sent) {
  std::uint32_t coming = 0;
  for (const LeafRange range : toggled) {
    // Toggled ranges do not straddle the borders of the list's own.
    for (std::uint32_t leaf = range.first; leaf != range.last; ++leaf) {
      if (complete_[leaf]) continue;
      if (containsLeaf(list_.list(), leaf)) {
        std::erase(incomplete_, leaf);
        continue;
      }
      ++coming;
      if (!cache_.hasLeaf(leaf)) addRecord(leaf);
      incomplete_.push_back(leaf);
    }
  }
  sent.misses = coming;
}

void TileMirror::addRecord(std::uint32_t leaf) {
  const SceneLeaf& from = scene_->leaves[leaf];
  cache_.addLeaf(leaf, scene_->assets.row(from.drawable).id, scene_->assets.row(from.state).id);
  newRecords_.push_back(leaf);
}

void TileMirror::addMissing(std::uint32_t asset) {
  for (const std::uint32_t needed : scene_->assets.needsOf(asset))
    addMissing(needed);
  if (!cache_.hasAsset(scene_->assets.row(asset).id)) group_.push_back(asset);
}

TileMirror::Fit TileMirror::sendAssetsOf(std::uint32_t leaf, Room& room, Sent& sent) {
  group_.clear();
  addMissing(scene_->leaves[leaf].state);
  addMissing(scene_->leaves[leaf].drawable);
  std::uint64_t bytes = 0, wireBytes = 0;
  for (const std::uint32_t asset : group_) {
    bytes += scene_->assets.row(asset).bytes;
    if (!onDisk_[asset]) wireBytes += scene_->assets.row(asset).bytes;
  }
  if (group_.empty()) {
    complete_[leaf] = true;
    return Fit::Sent;
  }
  if (bytes + LeafCache::kRecordBytes > room.cacheBytes) return Fit::Never;
  const bool isFirst = newAssets_.empty();
  if (room.isBounded && wireBytes > room.uploadBytes && !isFirst) return Fit::NotNow;
  for (const std::uint32_t asset : group_) {
    const AssetRow& row = scene_->assets.row(asset);
    needs_.clear();
    for (const std::uint32_t needed : scene_->assets.needsOf(asset))
      needs_.push_back(scene_->assets.row(needed).id);
    cache_.addAsset(row.id, row.bytes, needs_);
    newAssets_.push_back(asset);
    if (onDisk_[asset]) ++sent.diskHits;
  }
  sent.assets += static_cast<std::uint32_t>(group_.size());
  sent.assetBytes += wireBytes;
  room.uploadBytes -= std::min(room.uploadBytes, wireBytes);
  room.cacheBytes -= bytes + LeafCache::kRecordBytes;
  complete_[leaf] = true;
  return Fit::Sent;
}

void TileMirror::sortByNeed(std::vector<std::uint32_t>& leaves, const Vec3& eye) {
  ranked_.clear();
  for (const std::uint32_t leaf : leaves) {
    const Sphere& sphere = scene_->hierarchy.sphere(scene_->hierarchy.nodeOfLeaf(leaf));
    // About its size on the screen; what holds the eye is as large as can be.
    const double size = sphere.radius / std::max((sphere.center - eye).norm() - sphere.radius, 1e-300);
    ranked_.emplace_back(-size, leaf);
  }
  std::sort(ranked_.begin(), ranked_.end());
  for (std::size_t i = 0; i < leaves.size(); ++i)
    leaves[i] = ranked_[i].second;
}

void TileMirror::completeWhatIsSeen(const FrameOrder& order, Room& room, Sent& sent) {
  if (incomplete_.empty()) return;
  sortByNeed(incomplete_, order.frustum.eye);
  std::size_t left = 0;
  for (const std::uint32_t leaf : incomplete_) {
    const Fit fit = sendAssetsOf(leaf, room, sent);
    sent.isCacheTooSmall = sent.isCacheTooSmall || fit == Fit::Never;
    if (fit != Fit::Sent) incomplete_[left++] = leaf;
  }
  incomplete_.resize(left);
}

void TileMirror::sendAhead(const FrameOrder& order, Room& room, Sent& sent) {
  // More than a part of the cache sent ahead at a time would push itself out again.
  const std::uint64_t stretch = std::max(1U, options_.predictFrames);
  if (order.frame / stretch != stretchFrame_) stretchFrame_ = order.frame / stretch, aheadBytes_ = 0;
  if (cache_.budgetBytes() != LeafCache::kNoBudget) {
    const std::uint64_t share = cache_.budgetBytes() / 4;
    room.cacheBytes = std::min(room.cacheBytes / 4 * 3, share - std::min(share, aheadBytes_));
  }
  candidates_.clear();
  forEachLeaf(*order.predicted, [&](std::uint32_t leaf) {
    if (!complete_[leaf] && candidates_.size() < kMostCandidates) candidates_.push_back(leaf);
  });
  if (candidates_.empty()) return;
  sortByNeed(candidates_, order.frustum.eye);
  const std::uint64_t before = sent.assetBytes, cacheBefore = room.cacheBytes;
  for (const std::uint32_t leaf : candidates_) {
    // What is seen now waits for room in the cache, not for this.
    if (std::find(incomplete_.begin(), incomplete_.end(), leaf) != incomplete_.end()) continue;
    if (!cache_.hasLeaf(leaf)) {
      if (room.cacheBytes < LeafCache::kRecordBytes) break;
      addRecord(leaf);
    }
    if (sendAssetsOf(leaf, room, sent) == Fit::NotNow) break;
  }
  sent.predictedBytes = sent.assetBytes - before;
  aheadBytes_ += cacheBefore - room.cacheBytes;
}

/// Where the cache is nearly full, what will be needed soon must not be what goes next.
void TileMirror::sendKeep(net::Connection& connection, const VisibleList& predicted, Sent& sent) {
  if (++keepTurn_ % kKeepEvery != 0 || cache_.bytes() < cache_.budgetBytes() / 4 * 3) return;
  kept_.clear();
  forEachLeaf(predicted, [&](std::uint32_t leaf) {
    if (complete_[leaf]) appendRange(kept_, {leaf, leaf + 1});
  });
  if (kept_.empty()) return;
  forEachLeaf(kept_, [this](std::uint32_t leaf) { cache_.keep(leaf); });
  proto::encodeToggles(kept_, delta_);
  const proto::Bytes bytes = proto::encode(proto::Keep{delta_});
  sent.listBytes += bytes.size();
  traffic_->listBytes += bytes.size();
  connection.queue(std::span<const std::byte>(bytes));
}

void TileMirror::sendFrame(net::Connection& connection, proto::Encoder& encoder, const FrameOrder& order,
                           Sent& sent) {
  // Of the leaves that toggled, those that came outnumber those that went by what the list has grown.
  const std::uint64_t had = order.baseFrame == 0 ? 0 : listLeafCount_;
  const std::uint64_t came = (leafCount(*order.toggled) + order.leafCount - had) / 2;
  sent.hits = static_cast<std::uint32_t>(came - std::min<std::uint64_t>(came, sent.misses));
  if (order.baseFrame == 0) list_.reset();
  list_.encode(*order.toggled, delta_);
  listLeafCount_ = order.leafCount;

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
  sent.listBytes += bytes.size();
  traffic_->listBytes += bytes.size();
  connection.queue(bytes);
  pendingFrame_ = order.frame;
}

void TileMirror::queueGeometry(net::Connection& connection, Sent& sent) {
  sent.leaves = static_cast<std::uint32_t>(newRecords_.size());
  for (std::size_t first = 0; first < newRecords_.size(); first += kLeafBatch) {
    const auto begin = newRecords_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto count = static_cast<std::ptrdiff_t>(std::min(kLeafBatch, newRecords_.size() - first));
    sendLazily(connection, traffic_,
               [scene = scene_, leaves = std::vector<std::uint32_t>(begin, begin + count)] {
                 return encodeLeaves(*scene, leaves);
               });
  }
  if (newAssets_.empty()) return;
  std::vector<OrderedAsset> batch;
  std::size_t batchBytes = 0;
  const auto flush = [&] {
    if (batch.empty()) return;
    sendLazily(connection, traffic_, [assets = &scene_->assets, chosen = std::exchange(batch, {})] {
      return encodeAssets(*assets, chosen);
    });
    batchBytes = 0;
  };
  for (const std::uint32_t number : newAssets_) {
    const std::size_t bytes = onDisk_[number] ? 0 : scene_->assets.row(number).bytes;
    if (batchBytes + bytes > kAssetBatchBytes || batch.size() == kMostAssetsInBatch) flush();
    batch.push_back({number, onDisk_[number]});
    batchBytes += bytes;
  }
  flush();
}

/// Records tell where leaves were when the scene was loaded, so that those just sent need their pose, too;
/// and a tile that missed frames missed the poses that came with them.
void TileMirror::sendPoses(net::Connection& connection, const SceneMotion& motion, std::uint64_t frame,
                           Sent& sent) {
  const bool keptUp = posesFrame_ != 0 && posesFrame_ + 1 == frame;
  posesFrame_ = frame;
  posed_.clear();
  for (const std::uint32_t leaf : keptUp ? motion.moved() : motion.posed()) {
    if (cache_.hasLeaf(leaf)) posed_.push_back(leaf);
  }
  for (const std::uint32_t leaf : newRecords_) {
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

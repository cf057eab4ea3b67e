#include "client/tile_cache.h"

#include <chrono>

#include <Eigen/LU>

#include "proto/list_codec.h"
#include "proto/pose_codec.h"

namespace tessera {

namespace {

/// The first bytes of a hash are as good an order as any, and the same everywhere.
std::uint32_t rankOf(const proto::Sha256& id) {
  std::uint32_t rank = 0;
  for (int i = 0; i < 4; ++i)
    rank = rank << 8 | id[static_cast<std::size_t>(i)];
  return rank;
}

osg::Vec3d toOsg(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

osg::ref_ptr<osg::Billboard> billboardOf(const proto::LeafBillboard& from) {
  osg::ref_ptr<osg::Billboard> billboard = new osg::Billboard;
  switch (from.mode) {
    case proto::BillboardMode::PointRotEye:
      billboard->setMode(osg::Billboard::POINT_ROT_EYE);
      break;
    case proto::BillboardMode::PointRotWorld:
      billboard->setMode(osg::Billboard::POINT_ROT_WORLD);
      break;
    case proto::BillboardMode::AxialRot:
      billboard->setMode(osg::Billboard::AXIAL_ROT);
      break;
  }
  billboard->setAxis(toOsg(from.axis));
  billboard->setNormal(toOsg(from.normal));
  return billboard;
}

}  // namespace

TileCache::TileCache(Options options) : options_(std::move(options)), books_(options_.budgetBytes) {}

Status TileCache::add(const proto::Assets& message) {
  for (const proto::Asset& asset : message.assets) {
    if (Status status = addAsset(asset); !status) return status;
  }
  return Done{};
}

Result<osg::ref_ptr<osg::Object>> TileCache::decode(proto::AssetKind kind, std::string_view bytes) const {
  if (kind == proto::AssetKind::Image) {
    auto image = codec_.readImage(bytes);
    if (!image) return image.error();
    return osg::ref_ptr<osg::Object>(image->get());
  }
  return codec_.read(bytes, [this](const std::string& name) {
    const auto id = imageNames_.find(name);
    const auto found = id == imageNames_.end() ? images_.end() : images_.find(id->second);
    return found == images_.end() ? osg::ref_ptr<osg::Image>() : found->second;
  });
}

/// From the message or the disk; empty where the disk has it not.
Result<std::string> TileCache::bytesOf(const proto::Asset& asset) {
  const AssetId id{asset.id};
  if (asset.diskBytes == 0) {
    if (assetIdOf(asset.bytes) != id) return runtimeError("asset " + id.hex(), "was damaged on its way");
    if (options_.disk) {
      // A disk that is full costs the next start some time, and nothing else.
      (void)options_.disk->add(id, static_cast<AssetKind>(asset.kind), asset.bytes);
    }
    return std::string(reinterpret_cast<const char*>(asset.bytes.data()), asset.bytes.size());
  }
  if (options_.disk) {
    if (const auto stored = options_.disk->find(id)) {
      auto bytes = options_.disk->read(id, *stored);
      if (bytes && bytes->size() == asset.diskBytes) return bytes;
    }
  }
  lacked_.push_back(asset.id);
  return std::string();
}

Status TileCache::addAsset(const proto::Asset& asset) {
  const AssetId id{asset.id};
  auto bytes = bytesOf(asset);
  if (!bytes) return bytes.error();
  std::vector<AssetId> needs;
  for (const proto::Sha256& needed : asset.needs)
    needs.push_back(AssetId{needed});
  books_.addAsset(id, asset.size(), needs);
  if (bytes->empty()) return Done{};
  Waiting waiting{id, asset.kind, std::move(*bytes)};
  if (uploadMs_ <= 0) return make(waiting);
  waiting_.push_back(std::move(waiting));
  return Done{};
}

Status TileCache::prepare() {
  const auto start = std::chrono::steady_clock::now();
  while (!waiting_.empty()) {
    // It may have been dropped while it waited.
    if (books_.hasAsset(waiting_.front().id)) {
      if (Status status = make(waiting_.front()); !status) return status;
    }
    waiting_.pop_front();
    const std::chrono::duration<float, std::milli> spent = std::chrono::steady_clock::now() - start;
    if (uploadMs_ > 0 && spent.count() >= uploadMs_) break;
  }
  return Done{};
}

Status TileCache::make(const Waiting& asset) {
  osg::ref_ptr<osg::Object> object;
  if (options_.decodes) {
    auto read = decode(asset.kind, asset.bytes);
    if (!read) return runtimeError("asset " + asset.id.hex(), read.error().what);
    object = *read;
  }
  bool isRightKind = true;
  switch (asset.kind) {
    case proto::AssetKind::Drawable: {
      auto& drawable = drawables_[asset.id] = dynamic_cast<osg::Drawable*>(object.get());
      isRightKind = !options_.decodes || drawable;
      if (!drawable) break;
      if (Status status = DeformSource::takeFrom(*drawable); !status)
        return runtimeError("asset " + asset.id.hex(), status.error().what);
      break;
    }
    case proto::AssetKind::State: {
      auto& state = states_[asset.id] = dynamic_cast<osg::StateSet*>(object.get());
      isRightKind = !options_.decodes || state;
      break;
    }
    case proto::AssetKind::Image: {
      auto& image = images_[asset.id] = dynamic_cast<osg::Image*>(object.get());
      imageNames_[asset.id.hex()] = asset.id;
      isRightKind = !options_.decodes || image;
      break;
    }
  }
  if (!isRightKind) return runtimeError("asset " + asset.id.hex(), "is not of the kind that the master said");
  return Done{};
}

Status TileCache::add(const proto::Leaves& message, std::uint32_t leafCount) {
  for (const proto::LeafRecord& record : message.leaves) {
    const std::string name = "leaf " + std::to_string(record.id);
    if (record.id >= leafCount)
      return runtimeError(name, "is beyond the scene's " + std::to_string(leafCount) + " leaves");
    books_.addLeaf(record.id, AssetId{record.drawable}, AssetId{record.state});
    CachedLeaf& leaf = leaves_[record.id];
    leaf = CachedLeaf{};
    leaf.drawableId = AssetId{record.drawable};
    leaf.stateId = AssetId{record.state};
    leaf.stateRank = rankOf(record.state);
    leaf.localToWorld = record.localToWorld;
    leaf.center = record.center;
    leaf.boxCenter = record.center;
    leaf.halfAxes = record.halfAxes;
    leaf.meanRgb = record.meanRgb;
    leaf.recordToWorld = record.localToWorld;
    const Mat3 linear = record.localToWorld.topLeftCorner<3, 3>();
    leaf.localCenter = linear.inverse() * (record.center - record.localToWorld.topRightCorner<3, 1>());
    if (!leaf.localCenter.allFinite()) leaf.localCenter.setZero();
    if (record.billboard && options_.decodes) {
      leaf.billboard = billboardOf(*record.billboard);
      leaf.billboardPosition = toOsg(record.billboard->position);
    }
  }
  return Done{};
}

Status TileCache::keep(const proto::Keep& message, std::uint32_t leafCount) {
  const auto kept = proto::applyListDelta({}, message.leaves, leafCount);
  if (!kept) return kept.error();
  forEachLeaf(*kept, [this](std::uint32_t leaf) { books_.keep(leaf); });
  return Done{};
}

void TileCache::show(const VisibleList& toggled) {
  books_.show(toggled);
  const LeafCache::Dropped& dropped = books_.trim();
  for (const std::uint32_t leaf : dropped.leaves)
    leaves_.erase(leaf);
  for (const AssetId& id : dropped.assets) {
    drawables_.erase(id);
    states_.erase(id);
    if (images_.erase(id) > 0) imageNames_.erase(id.hex());
  }
}

bool TileCache::isComplete(std::uint32_t leaf) const {
  const auto found = leaves_.find(leaf);
  return found != leaves_.end() && drawables_.contains(found->second.drawableId) &&
         states_.contains(found->second.stateId);
}

CachedLeaf* TileCache::find(std::uint32_t leaf) {
  const auto found = leaves_.find(leaf);
  if (found == leaves_.end()) return nullptr;
  CachedLeaf& cached = found->second;
  if (cached.canBeDrawn()) return &cached;
  const auto drawable = drawables_.find(cached.drawableId);
  const auto state = states_.find(cached.stateId);
  if (drawable == drawables_.end() || state == states_.end()) return &cached;
  cached.drawable = drawable->second;
  cached.state = state->second;
  if (!cached.joints.empty() || !cached.weights.empty()) (void)shape(cached);
  return &cached;
}

Status TileCache::add(const proto::Poses& message) {
  for (const proto::Pose& pose : message.poses) {
    const std::string name = "pose of leaf " + std::to_string(pose.id);
    CachedLeaf* leaf = find(pose.id);
    if (!leaf) return runtimeError(name, "comes before the leaf's record");
    if (Status status = place(*leaf, pose); !status) return runtimeError(name, status.error().what);
  }
  return Done{};
}

Status TileCache::place(CachedLeaf& leaf, const proto::Pose& pose) const {
  if (pose.form == proto::PoseForm::Matrix) leaf.localToWorld = pose.localToWorld;
  if (pose.form == proto::PoseForm::Steps) {
    const Mat4 reached = proto::fromSteps(leaf.recordToWorld, pose.steps);
    if (!reached.allFinite()) return runtimeError("", "leads beyond the range of numbers");
    leaf.localToWorld = reached;
  }
  // Good enough to sort by: where the middle of the record's sphere has gone.
  const Vec3 center = pose.joints.empty() ? leaf.localCenter : Vec3(Vec3::Zero());
  leaf.center = leaf.localToWorld.topLeftCorner<3, 3>() * center + leaf.localToWorld.topRightCorner<3, 1>();
  if ((pose.joints.empty() && pose.weights.empty()) || !options_.decodes) return Done{};
  if (!pose.joints.empty()) leaf.joints = pose.joints;
  if (!pose.weights.empty()) leaf.weights = pose.weights;
  return leaf.drawable ? shape(leaf) : Done{};
}

Status TileCache::shape(CachedLeaf& leaf) {
  if (!leaf.deformer) {
    if (!leaf.drawable->asGeometry() || !DeformSource::of(*leaf.drawable))
      return runtimeError("", "has a shape for a drawable that keeps its own");
    leaf.deformer = new LeafDeformer(*leaf.drawable->asGeometry());
    leaf.drawable = leaf.deformer->geometry();
  }
  const Status status = leaf.deformer->pose(leaf.joints, leaf.weights);
  leaf.joints.clear();
  leaf.weights.clear();
  return status;
}

}  // namespace tessera

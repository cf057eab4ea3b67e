#include "client/tile_cache.h"

#include <cstring>

#include <Eigen/LU>

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
    const auto found = images_.find(name);
    return found == images_.end() ? osg::ref_ptr<osg::Image>() : found->second;
  });
}

Status TileCache::addAsset(const proto::Asset& asset) {
  const AssetId id{asset.id};
  if (assetIdOf(asset.bytes) != id) return runtimeError("asset " + id.hex(), "was damaged on its way");
  const std::string_view bytes(reinterpret_cast<const char*>(asset.bytes.data()), asset.bytes.size());
  osg::ref_ptr<osg::Object> object;
  if (decodes_) {
    auto read = decode(asset.kind, bytes);
    if (!read) return runtimeError("asset " + id.hex(), read.error().what);
    object = *read;
  }
  bool isRightKind = true;
  switch (asset.kind) {
    case proto::AssetKind::Drawable: {
      auto& drawable = drawables_[id] = dynamic_cast<osg::Drawable*>(object.get());
      isRightKind = !decodes_ || drawable;
      if (!drawable) break;
      if (Status status = DeformSource::takeFrom(*drawable); !status)
        return runtimeError("asset " + id.hex(), status.error().what);
      break;
    }
    case proto::AssetKind::State: {
      auto& state = states_[id] = dynamic_cast<osg::StateSet*>(object.get());
      isRightKind = !decodes_ || state;
      break;
    }
    case proto::AssetKind::Image: {
      auto& image = images_[id.hex()] = dynamic_cast<osg::Image*>(object.get());
      isRightKind = !decodes_ || image;
      break;
    }
  }
  if (!isRightKind) return runtimeError("asset " + id.hex(), "is not of the kind that the master said");
  return Done{};
}

Status TileCache::add(const proto::Leaves& message, std::uint32_t leafCount) {
  for (const proto::LeafRecord& record : message.leaves) {
    const std::string name = "leaf " + std::to_string(record.id);
    if (record.id >= leafCount)
      return runtimeError(name, "is beyond the scene's " + std::to_string(leafCount) + " leaves");
    const auto drawable = drawables_.find(AssetId{record.drawable});
    const auto state = states_.find(AssetId{record.state});
    if (drawable == drawables_.end() || state == states_.end())
      return runtimeError(name, "names an asset that was not sent");
    CachedLeaf& leaf = leaves_[record.id];
    leaf.drawable = drawable->second;
    leaf.state = state->second;
    leaf.stateRank = rankOf(record.state);
    leaf.localToWorld = record.localToWorld;
    leaf.center = record.center;
    leaf.recordToWorld = record.localToWorld;
    leaf.deformer = nullptr;
    const Mat3 linear = record.localToWorld.topLeftCorner<3, 3>();
    leaf.localCenter = linear.inverse() * (record.center - record.localToWorld.topRightCorner<3, 1>());
    if (!leaf.localCenter.allFinite()) leaf.localCenter.setZero();
    if (record.billboard && decodes_) {
      leaf.billboard = billboardOf(*record.billboard);
      leaf.billboardPosition = toOsg(record.billboard->position);
    }
  }
  return Done{};
}

Status TileCache::add(const proto::Poses& message) {
  for (const proto::Pose& pose : message.poses) {
    const std::string name = "pose of leaf " + std::to_string(pose.id);
    const auto leaf = leaves_.find(pose.id);
    if (leaf == leaves_.end()) return runtimeError(name, "comes before the leaf's record");
    if (Status status = place(leaf->second, pose); !status) return runtimeError(name, status.error().what);
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
  if ((pose.joints.empty() && pose.weights.empty()) || !decodes_) return Done{};
  if (!leaf.deformer) {
    if (!leaf.drawable->asGeometry() || !DeformSource::of(*leaf.drawable))
      return runtimeError("", "has a shape for a drawable that keeps its own");
    leaf.deformer = new LeafDeformer(*leaf.drawable->asGeometry());
    leaf.drawable = leaf.deformer->geometry();
  }
  return leaf.deformer->pose(pose.joints, pose.weights);
}

const CachedLeaf* TileCache::find(std::uint32_t leaf) const {
  const auto found = leaves_.find(leaf);
  return found == leaves_.end() ? nullptr : &found->second;
}

}  // namespace tessera

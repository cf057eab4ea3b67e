#include "common/scene/leaf_triangles.h"

#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <osg/Drawable>

#include "common/scene/drawable_triangles.h"
#include "common/scene/osgb_codec.h"

namespace tessera {

struct LeafTriangles::Decoded {
  OsgbCodec codec;
  std::unordered_map<AssetId, DrawableTriangles, AssetIdHash> drawables;
  std::vector<Vec3> vertices;                  ///< world space, of the last leaf
  std::vector<std::array<Vec3, 3>> triangles;  ///< likewise

  Result<const DrawableTriangles*> get(const AssetStore& assets, const AssetId& id) {
    if (const auto known = drawables.find(id); known != drawables.end()) return &known->second;
    const Asset* asset = assets.find(id);
    if (!asset) return runtimeError(id.hex(), "is not among the scene's assets");
    const auto object = codec.read(asset->bytes, {});
    if (!object) return object.error();
    const auto* drawable = dynamic_cast<const osg::Drawable*>(object->get());
    if (!drawable) return runtimeError(id.hex(), "is not a drawable");
    DrawableTriangles read = trianglesOf(*drawable);
    if (read.isMalformed) return runtimeError(id.hex(), "has an index out of range");
    return &drawables.emplace(id, std::move(read)).first->second;
  }
};

LeafTriangles::LeafTriangles(const Scene& scene) : scene_(&scene), decoded_(std::make_unique<Decoded>()) {}

LeafTriangles::~LeafTriangles() = default;

Result<std::span<const std::array<Vec3, 3>>> LeafTriangles::of(std::uint32_t leaf) {
  using Triangles = std::span<const std::array<Vec3, 3>>;
  const SceneLeaf& from = scene_->leaves.at(leaf);
  if (from.billboard) return Triangles{};
  const auto local = decoded_->get(scene_->assets, from.drawable);
  if (!local) return local.error();
  std::vector<Vec3>& vertices = decoded_->vertices;
  vertices.clear();
  for (const Vec3& p : (*local)->vertices)
    vertices.emplace_back((from.localToWorld * p.homogeneous()).head<3>());
  decoded_->triangles.clear();
  for (const auto& [a, b, c] : (*local)->triangles)
    decoded_->triangles.push_back({vertices[a], vertices[b], vertices[c]});
  return Triangles(decoded_->triangles);
}

}  // namespace tessera

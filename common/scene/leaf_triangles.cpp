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
  std::unordered_map<std::uint32_t, DrawableTriangles> drawables;  ///< by number
  std::vector<Vec3> vertices;                                      ///< world space, of the last leaf
  std::vector<std::array<Vec3, 3>> triangles;                      ///< likewise

  Result<const DrawableTriangles*> get(const AssetTable& assets, std::uint32_t asset) {
    if (const auto known = drawables.find(asset); known != drawables.end()) return &known->second;
    const auto bytes = assets.read(asset);
    if (!bytes) return bytes.error();
    const std::string name = assets.row(asset).id.hex();
    const auto object = codec.read(**bytes, {});
    if (!object) return object.error();
    const auto* drawable = dynamic_cast<const osg::Drawable*>(object->get());
    if (!drawable) return runtimeError(name, "is not a drawable");
    DrawableTriangles read = trianglesOf(*drawable);
    if (read.isMalformed) return runtimeError(name, "has an index out of range");
    return &drawables.emplace(asset, std::move(read)).first->second;
  }
};

LeafTriangles::LeafTriangles(const Scene& scene) : scene_(&scene), decoded_(std::make_unique<Decoded>()) {}

LeafTriangles::~LeafTriangles() = default;

Result<std::span<const std::array<Vec3, 3>>> LeafTriangles::of(std::uint32_t leaf) {
  using Triangles = std::span<const std::array<Vec3, 3>>;
  if (leaf >= scene_->leaves.size())
    return runtimeError("leaf " + std::to_string(leaf), "is none of the scene's");
  const SceneLeaf& from = scene_->leaves[leaf];
  if (scene_->billboardOf(from)) return Triangles{};
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

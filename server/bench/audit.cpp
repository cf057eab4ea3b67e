#include "server/bench/audit.h"

#include <algorithm>
#include <span>

#include "common/geometry/bounded_plane.h"
#include "common/geometry/exact_frustum.h"

namespace tessera {

namespace {

/// Certain rejection of most leaves, so that only the others' triangles are looked at. Independent of the
/// cullers: sides alone, from the tile's own corners.
class Sides {
 public:
  explicit Sides(const Frustum& frustum) : eye_(frustum.eye) {
    for (std::size_t i = 0; i < 4; ++i)
      planes_[i] = planeThroughEye(frustum.corners[i] - eye_, frustum.corners[(i + 1) % 4] - eye_);
  }
  [[nodiscard]] bool mayMeet(const Aabb& box) const {
    const RelativeAabb bounds(box, eye_);
    return std::none_of(planes_.begin(), planes_.end(), [&bounds](const BoundedPlane& plane) {
      return classify(bounds, plane) == Side::Outside;
    });
  }

 private:
  Vec3 eye_;
  std::array<BoundedPlane, 4> planes_;
};

}  // namespace

Status Audit::add(std::uint64_t frame, const WallView& view, const cull::Result& result) {
  for (std::size_t tile = 0; tile < view.tiles.size(); ++tile) {
    const ExactFrustum exact(view.tiles[tile]);
    const Sides sides(view.tiles[tile]);
    const VisibleList& list = result.lists[tile];
    for (std::uint32_t leaf = 0; leaf < scene_->leaves.size(); ++leaf) {
      const bool isListed = containsLeaf(list, leaf);
      pairs_ += isListed ? 1 : 0;
      if (scene_->leaves[leaf].billboard) {
        exactPairs_ += isListed ? 1 : 0;
        continue;
      }
      // A listed leaf is judged by its triangles even where its box is certainly outside.
      const std::uint32_t node = scene_->hierarchy.nodeOfLeaf(leaf);
      if (!isListed && !sides.mayMeet(scene_->hierarchy.aabb(node))) continue;
      const auto triangles = triangles_.of(leaf);
      if (!triangles) return triangles.error();
      const bool meets = std::any_of(triangles->begin(), triangles->end(),
                                     [&exact](const auto& triangle) { return exact.meets(triangle); });
      exactPairs_ += meets && isListed ? 1 : 0;
      if (meets && !isListed && drops_++ == 0) {
        firstDrop_ = "frame " + std::to_string(frame) + ", tile " + std::to_string(tile) + ", leaf " +
                     std::to_string(leaf);
      }
    }
    exactDecisions_ += exact.exactDecisions();
  }
  return Done{};
}

double Audit::excessPercent() const {
  if (exactPairs_ == 0) return 0;
  return 100.0 * static_cast<double>(pairs_ - exactPairs_) / static_cast<double>(exactPairs_);
}

}  // namespace tessera

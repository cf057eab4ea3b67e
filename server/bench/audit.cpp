#include "server/bench/audit.h"

#include <algorithm>
#include <array>

#include "common/geometry/bounded_plane.h"

namespace tessera {

namespace {

constexpr std::uint32_t kBlockLeaves = 64;

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

const Aabb& boxOf(const Scene& scene, std::uint32_t leaf) {
  return scene.hierarchy.aabb(scene.hierarchy.nodeOfLeaf(leaf));
}

}  // namespace

Audit::Audit(const Scene& scene, std::size_t candidates)
    : scene_(&scene), triangles_(scene), absent_(scene.hierarchy.absentLeaves()), verdicts_(candidates) {
  const auto count = static_cast<std::uint32_t>(scene.leaves.size());
  blocks_.resize((count + kBlockLeaves - 1) / kBlockLeaves);
  for (std::uint32_t leaf = 0; leaf < count; ++leaf)
    blocks_[leaf / kBlockLeaves].extend(boxOf(scene, leaf));
}

void Audit::findCandidates(const Frustum& tile) {
  const Sides sides(tile);
  const auto count = static_cast<std::uint32_t>(scene_->leaves.size());
  for (std::uint32_t block = 0; block < blocks_.size(); ++block) {
    if (!sides.mayMeet(blocks_[block])) continue;
    const std::uint32_t first = block * kBlockLeaves, end = std::min(count, first + kBlockLeaves);
    for (std::uint32_t leaf = first; leaf < end; ++leaf) {
      if (sides.mayMeet(boxOf(*scene_, leaf))) meets_[leaf] = Meets::Open;
    }
  }
}

Status Audit::decide(std::span<ExactFrustum> seen) {
  meeting_ = 0;
  for (const LeafRange range : absent_)
    std::fill(meets_.begin() + range.first, meets_.begin() + range.last, Meets::No);
  for (std::uint32_t leaf = 0; leaf < meets_.size(); ++leaf) {
    if (meets_[leaf] != Meets::Open) continue;
    if (scene_->billboardOf(scene_->leaves[leaf])) {
      meets_[leaf] = Meets::Billboard;
      continue;
    }
    const auto triangles = triangles_.of(leaf);
    if (!triangles) return triangles.error();
    const bool meets = std::any_of(seen.begin(), seen.end(), [&triangles](ExactFrustum& exact) {
      return std::any_of(triangles->begin(), triangles->end(),
                         [&exact](const auto& triangle) { return exact.meets(triangle); });
    });
    meets_[leaf] = meets ? Meets::Yes : Meets::No;
    meeting_ += meets ? 1 : 0;
  }
  return Done{};
}

void Audit::judge(const VisibleList& list, Verdict& verdict, std::uint64_t frame, std::size_t tile) const {
  std::uint64_t found = 0;
  forEachLeaf(list, [&](std::uint32_t leaf) {
    ++verdict.pairs;
    found += meets_[leaf] == Meets::Yes ? 1 : 0;
    verdict.exactPairs += meets_[leaf] == Meets::Yes || meets_[leaf] == Meets::Billboard ? 1 : 0;
  });
  if (found == meeting_) return;
  verdict.drops += meeting_ - found;
  for (std::uint32_t leaf = 0; leaf < meets_.size() && verdict.firstDrop.empty(); ++leaf) {
    if (meets_[leaf] != Meets::Yes || containsLeaf(list, leaf)) continue;
    verdict.firstDrop = "frame " + std::to_string(frame) + ", tile " + std::to_string(tile) + ", leaf " +
                        std::to_string(leaf);
  }
}

Status Audit::add(std::uint64_t frame, const WallView& view,
                  std::span<const std::vector<VisibleList>* const> lists) {
  for (std::size_t tile = 0; tile < view.tiles.size(); ++tile) {
    std::vector<ExactFrustum> seen;
    meets_.assign(scene_->leaves.size(), Meets::CertainlyNot);
    const auto add = [&](const Frustum& frustum) {
      findCandidates(frustum);
      seen.emplace_back(frustum);
    };
    if (view.left.empty()) {
      add(view.tiles[tile]);
    } else {
      add(view.left[tile]);
      add(view.right[tile]);
    }
    // A listed leaf is judged by its triangles even where its box is certainly outside.
    for (const auto* candidate : lists)
      forEachLeaf((*candidate)[tile], [this](std::uint32_t leaf) { meets_[leaf] = Meets::Open; });
    if (Status status = decide(seen); !status) return status;
    for (const ExactFrustum& exact : seen)
      exactDecisions_ += exact.exactDecisions();
    for (std::size_t i = 0; i < lists.size(); ++i)
      judge((*lists[i])[tile], verdicts_[i], frame, tile);
  }
  return Done{};
}

double Audit::Verdict::excessPercent() const {
  if (exactPairs == 0) return 0;
  return 100.0 * static_cast<double>(pairs - exactPairs) / static_cast<double>(exactPairs);
}

}  // namespace tessera

#include "common/cull/culler.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tessera::cull {

namespace {

// Each view fetches one kind of bound and brings it into the coordinates of the eye.
struct SphereView : RelativeSphere {
  SphereView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye)
      : RelativeSphere(oh.sphere(node), eye) {}
};
struct AabbView : RelativeAabb {
  AabbView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye)
      : RelativeAabb(oh.aabb(node), eye) {}
};
struct ObbView : RelativeObb {
  ObbView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye) : RelativeObb(oh.obb(node), eye) {}
};

constexpr std::array kAlgorithms = {std::pair{Algorithm::None, "none"}, std::pair{Algorithm::Naive, "naive"},
                                    std::pair{Algorithm::Oh, "oh"},
                                    std::pair{Algorithm::Adaptive, "adaptive"}};
constexpr std::array kBounds = {std::pair{BoundsKind::Sphere, "sphere"}, std::pair{BoundsKind::Aabb, "aabb"},
                                std::pair{BoundsKind::Obb, "obb"}};

template <class Table>
auto findByName(const Table& table, std::string_view name) {
  std::optional<typename Table::value_type::first_type> found;
  for (const auto& [value, text] : table) {
    if (name == text) found = value;
  }
  return found;
}

template <class Table>
std::string_view findName(const Table& table, typename Table::value_type::first_type value) {
  for (const auto& [known, text] : table) {
    if (known == value) return text;
  }
  return "?";
}

/// The sides of the primary frustum that still bound the half of `frustum` on one side of its bisection; the
/// other side is replaced by the bisection plane itself. Sides are numbered as the frustum's corners: bottom,
/// right, top, left.
std::uint32_t relevantSides(const FrustumHierarchy& frusta, std::uint32_t frustum, bool positive) {
  const FrustumHierarchy::Node& negativeHalf = frusta.node(frusta.node(frustum).negative);
  const FrustumHierarchy::Node& positiveHalf = frusta.node(frusta.node(frustum).positive);
  const bool splitsColumns = negativeHalf.endColumn == positiveHalf.firstColumn;
  constexpr std::uint32_t bottom = 1, right = 2, top = 4, left = 8;
  if (splitsColumns) return ~(positive ? left : right);
  return ~(positive ? top : bottom);
}

}  // namespace

std::optional<Algorithm> algorithmFromName(std::string_view name) {
  return findByName(kAlgorithms, name);
}
std::optional<BoundsKind> boundsFromName(std::string_view name) {
  return findByName(kBounds, name);
}
std::string_view nameOf(Algorithm algorithm) {
  return findName(kAlgorithms, algorithm);
}
std::string_view nameOf(BoundsKind bounds) {
  return findName(kBounds, bounds);
}

const Result& Culler::cull(const FrustumHierarchy& frusta) {
  result_.lists.resize(frusta.tileCount());
  for (VisibleList& list : result_.lists)
    list.clear();
  result_.planeTests = 0;
  if (!scene_->empty()) {
    switch (options_.bounds) {
      case BoundsKind::Sphere:
        run<SphereView>(frusta);
        break;
      case BoundsKind::Aabb:
        run<AabbView>(frusta);
        break;
      case BoundsKind::Obb:
        run<ObbView>(frusta);
        break;
    }
  }
  result_.pairs = 0;
  for (const VisibleList& list : result_.lists)
    result_.pairs += leafCount(list);
  return result_;
}

template <class View>
void Culler::run(const FrustumHierarchy& frusta) {
  switch (options_.algorithm) {
    case Algorithm::None:
      for (VisibleList& list : result_.lists)
        appendRange(list, {0, scene_->leafCount()});
      break;
    case Algorithm::Naive:
      cullNaive<View>(frusta);
      break;
    case Algorithm::Oh:
      cullOh<View>(frusta);
      break;
    case Algorithm::Adaptive:
      cullAdaptive<View>(frusta);
      break;
  }
}

/// Tests the planes of `mask`. False: outside. Planes that the bound is wholly inside of leave the mask:
/// nothing below the node can be outside of them (plane masking, Assarsson and Moeller 2000).
template <class View>
bool Culler::testPlanes(const View& bounds, const FrustumPlanes& planes, std::uint32_t& mask) {
  for (std::uint32_t p = 0; p < planes.count; ++p) {
    if (!(mask & (1u << p))) continue;
    ++result_.planeTests;
    const Side side = classify(bounds, planes.planes[p]);
    if (side == Side::Outside) return false;
    if (side == Side::Inside) mask &= ~(1u << p);
  }
  return true;
}

template <class View>
void Culler::cullNaive(const FrustumHierarchy& frusta) {
  for (std::uint32_t leaf = 0; leaf < scene_->leafCount(); ++leaf) {
    const View bounds(*scene_, scene_->nodeOfLeaf(leaf), frusta.eye());
    for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile) {
      std::uint32_t mask = frusta.tile(tile).all();
      if (testPlanes(bounds, frusta.tile(tile), mask)) appendRange(result_.lists[tile], {leaf, leaf + 1});
    }
  }
}

template <class View>
void Culler::cullOh(const FrustumHierarchy& frusta) {
  for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile) {
    const FrustumPlanes& planes = frusta.tile(tile);
    tasks_.assign(1, {0, 0, planes.all()});
    while (!tasks_.empty()) {
      Task task = tasks_.back();
      tasks_.pop_back();
      const View bounds(*scene_, task.node, frusta.eye());
      if (!testPlanes(bounds, planes, task.mask)) continue;
      if (task.mask == 0 || scene_->isTerminal(task.node)) {
        appendRange(result_.lists[tile], scene_->leaves(task.node));
      } else {
        pushChildren(task.node, 0, task.mask);
      }
    }
  }
}

template <class View>
void Culler::cullAdaptive(const FrustumHierarchy& frusta) {
  // A tile's sides are sides of the wall or bisection planes on its path, so a node that arrives at the end
  // of FH has met them all: it is uncut by the bisections, and `mask` holds what is left of the primary
  // frustum.
  tasks_.assign(1, {0, 0, frusta.primary().all()});
  while (!tasks_.empty()) {
    Task task = tasks_.back();
    tasks_.pop_back();
    const View bounds(*scene_, task.node, frusta.eye());
    if (!testPlanes(bounds, frusta.primary(), task.mask)) continue;
    const bool isLeaf = scene_->isTerminal(task.node);

    bool cut = false;
    while (!cut && !frusta.node(task.frustum).isLeaf()) {
      const FrustumHierarchy::Node& frustum = frusta.node(task.frustum);
      const Side side = classify(bounds, frusta.bisection(task.frustum));
      ++result_.planeTests;
      cut = side == Side::Intersecting && !isLeaf;
      if (cut) break;
      if (side == Side::Intersecting) {  // nothing left to unfold but FH: both halves
        tasks_.push_back(
            {task.node, frustum.positive, task.mask & relevantSides(frusta, task.frustum, true)});
      }
      const bool positive = side == Side::Inside;
      task.mask &= relevantSides(frusta, task.frustum, positive);
      task.frustum = positive ? frustum.positive : frustum.negative;
    }
    if (!cut && (task.mask == 0 || isLeaf)) {
      appendRange(result_.lists[frusta.node(task.frustum).tile], scene_->leaves(task.node));
    } else {
      pushChildren(task.node, task.frustum, task.mask);
    }
  }
}

/// Pushes the children so that the first is popped first: lists then grow in order.
void Culler::pushChildren(std::uint32_t node, std::uint32_t frustum, std::uint32_t mask) {
  const std::size_t start = tasks_.size();
  const std::uint32_t end = scene_->subtreeEnd(node);
  for (std::uint32_t child = node + 1; child != end; child = scene_->subtreeEnd(child)) {
    tasks_.push_back({child, frustum, mask});
  }
  std::reverse(tasks_.begin() + static_cast<std::ptrdiff_t>(start), tasks_.end());
}

}  // namespace tessera::cull

#include "common/hierarchy/spatial_hierarchy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <utility>

namespace tessera {

namespace {

constexpr std::array<std::pair<HierarchyKind, std::string_view>, 5> kNames = {{
    {HierarchyKind::Graph, "graph"},
    {HierarchyKind::Bvh, "bvh"},
    {HierarchyKind::Octree, "octree"},
    {HierarchyKind::LooseOctree, "loose-octree"},
    {HierarchyKind::Kd, "kd"},
}};

/// More straddlers than this get a tree of their own below the node, so that branching stays bounded.
constexpr std::uint32_t kMaxKept = 8;
/// Levels of midpoint splits below which a range is halved at its median: clusters within clusters could
/// otherwise be peeled one by one through all exponents of a double.
constexpr std::uint32_t kMaxMidpointLevels = 64;
constexpr std::uint32_t kMaxOctreeLevels = 48;
constexpr std::uint32_t kMaxKdLevels = 3 * kMaxOctreeLevels;

double middle(double low, double high) {
  return 0.5 * low + 0.5 * high;  // the sum of the ends could overflow
}

int longestAxis(const Aabb& box) {
  int axis = 0;
  const Vec3 size = box.max - box.min;
  for (int k = 1; k < 3; ++k)
    axis = size[k] > size[axis] ? k : axis;
  return axis;
}

/// The half of `box` on one side of its middle plane.
Aabb halfOf(Aabb box, int axis, bool high) {
  const double plane = middle(box.min[axis], box.max[axis]);
  (high ? box.min : box.max)[axis] = plane;
  return box;
}

/// Splits ranges of one array of records top-down. Each split sorts a range stably into parts that are ranges
/// again, so the array ends in the order of the leaves. A stack of tasks stands for the recursion.
class SpatialBuilder {
 public:
  SpatialBuilder(HierarchyKind kind, std::span<const Bounds> items, std::span<const std::uint64_t> triangles,
                 std::uint64_t maxTrianglesPerLeaf)
      : items_(items), triangles_(triangles), maxTriangles_(maxTrianglesPerLeaf), kind_(kind) {
    records_.reserve(items.size());
    for (const Bounds& item : items)
      records_.push_back({item.aabb, static_cast<std::uint32_t>(records_.size())});
    scratch_.resize(records_.size());
    parts_.resize(records_.size());
  }

  SpatialHierarchy build() {
    const auto count = static_cast<std::uint32_t>(records_.size());
    if (count > 0) start(count);
    while (!tasks_.empty()) {
      const Task task = tasks_.back();
      tasks_.pop_back();
      if (task.first == task.last) {
        builder_.closeNode();
      } else if (fitsOneNode(task.first, task.last)) {
        addTerminal(task.first, task.last);
      } else {
        split(task);
      }
    }
    SpatialHierarchy built;
    built.hierarchy = builder_.finish();
    built.order.reserve(count);
    for (const Record& record : records_)
      built.order.push_back(record.index);
    return built;
  }

 private:
  struct Record {
    Aabb box;
    std::uint32_t index = 0;
  };
  /// A range to be made into a subtree; an empty one closes a node.
  struct Task {
    std::uint32_t first = 0, last = 0, level = 0;
    HierarchyKind rule = HierarchyKind::Bvh;
    Aabb cell = {};
  };
  /// Part 0 stays at the node; the others are its children.
  static constexpr std::size_t kMaxParts = 9;
  struct Parts {
    std::array<std::uint32_t, kMaxParts + 1> begin{};
    [[nodiscard]] std::uint32_t size(std::size_t part) const { return begin[part + 1] - begin[part]; }
  };

  void start(std::uint32_t count) {
    Task all{.first = 0, .last = count, .rule = kind_, .cell = contents(0, count)};
    if (kind_ == HierarchyKind::LooseOctree) {
      looseSide_ = (all.cell.max - all.cell.min).maxCoeff();
      all.cell.max = all.cell.min + Vec3::Constant(looseSide_);
    }
    tasks_.push_back(all);
  }

  [[nodiscard]] Aabb contents(std::uint32_t first, std::uint32_t last) const {
    Aabb box;
    for (std::uint32_t i = first; i < last; ++i)
      box.extend(records_[i].box);
    return box;
  }

  [[nodiscard]] bool fitsOneNode(std::uint32_t first, std::uint32_t last) const {
    if (last - first == 1) return true;
    std::uint64_t left = maxTriangles_;
    for (std::uint32_t i = first; i < last; ++i) {
      const std::uint64_t count = std::max<std::uint64_t>(triangles_[records_[i].index], 1);
      if (count > left) return false;
      left -= count;
    }
    return true;
  }

  void addTerminal(std::uint32_t first, std::uint32_t last) {
    group_.clear();
    for (std::uint32_t i = first; i < last; ++i)
      group_.push_back(items_[records_[i].index]);
    builder_.addGroup(group_);
  }

  /// A few straddlers become terminal children, as many to each as fit; more become one subtree.
  void addKept(std::uint32_t first, std::uint32_t last) {
    if (last - first > kMaxKept) {
      tasks_.push_back({.first = first, .last = last});
      return;
    }
    while (first < last) {
      std::uint32_t end = first + 1;
      while (end < last && fitsOneNode(first, end + 1))
        ++end;
      addTerminal(first, end);
      first = end;
    }
  }

  void split(const Task& task) {
    const Parts parts = partsOf(task);
    const std::uint32_t kept = parts.size(0);
    for (std::size_t part = 0; part < kMaxParts; ++part) {
      if (parts.size(part) == task.last - task.first && (part > 0 || kept > kMaxKept)) {
        splitAgain(task, part);
        return;
      }
    }
    builder_.openNode();
    tasks_.push_back({.first = task.last, .last = task.last});
    for (std::size_t part = kMaxParts; part-- > 1;) {
      if (parts.size(part) > 0) tasks_.push_back(childOf(task, parts, part));
    }
    if (kept > 0) addKept(parts.begin[0], parts.begin[1]);
  }

  /// Everything is in one part: no node is opened for that.
  void splitAgain(const Task& task, std::size_t part) {
    Task again = task;
    ++again.level;
    again.rule = part == 0 ? HierarchyKind::Bvh : task.rule;
    if (part > 0 && task.rule == HierarchyKind::LooseOctree) {
      again.cell = cellOf(task, part);
    } else if (part > 0) {
      again.cell = contents(task.first, task.last);
      if (again.cell.contains(task.cell)) again.rule = HierarchyKind::Bvh;
    }
    if (again.rule != task.rule) again.level = 0;
    tasks_.push_back(again);
  }

  [[nodiscard]] static Task childOf(const Task& task, const Parts& parts, std::size_t part) {
    return {.first = parts.begin[part],
            .last = parts.begin[part + 1],
            .level = task.level + 1,
            .rule = task.rule,
            .cell = cellOf(task, part)};
  }

  [[nodiscard]] static Aabb cellOf(const Task& task, std::size_t part) {
    if (task.rule == HierarchyKind::Bvh) return {};
    if (task.rule == HierarchyKind::Kd) return halfOf(task.cell, longestAxis(task.cell), part == 2);
    Aabb cell = task.cell;
    for (int k = 0; k < 3; ++k)
      cell = halfOf(cell, k, ((part - 1) >> k & 1) != 0);
    return cell;
  }

  Parts partsOf(const Task& task) {
    switch (task.rule) {
      case HierarchyKind::Octree:
        if (task.level < kMaxOctreeLevels) return octreeParts(task);
        break;
      case HierarchyKind::LooseOctree:
        if (task.level < kMaxOctreeLevels) return looseParts(task);
        break;
      case HierarchyKind::Kd:
        if (task.level < kMaxKdLevels) return kdParts(task);
        break;
      case HierarchyKind::Graph:
      case HierarchyKind::Bvh:
        return bvhParts(task);
    }
    // The end of the levels: the rest, taken as one part, is split again by the other rule.
    Parts parts;
    parts.begin.fill(task.last);
    parts.begin[0] = task.first;
    return parts;
  }

  Parts bvhParts(const Task& task) {
    Aabb centers;
    for (std::uint32_t i = task.first; i < task.last; ++i)
      centers.extend(records_[i].box.center());
    const int axis = longestAxis(centers);
    const double low = centers.min[axis], high = centers.max[axis];
    if (!(low < high)) return halves(task);
    if (task.level >= kMaxMidpointLevels) return medianParts(task, axis);
    // Between neighbouring doubles the middle is one of them; it must be above the low one to separate.
    const double above = std::nextafter(low, std::numeric_limits<double>::infinity());
    const double plane = std::clamp(middle(low, high), above, high);
    return distribute(task, [&](const Record& r) { return r.box.center()[axis] < plane ? 1U : 2U; });
  }

  static Parts halves(const Task& task) {
    Parts parts;
    parts.begin.fill(task.last);
    parts.begin[0] = parts.begin[1] = task.first;
    parts.begin[2] = task.first + (task.last - task.first) / 2;
    return parts;
  }

  Parts medianParts(const Task& task, int axis) {
    const auto key = [axis](const Record& r) { return std::tuple(r.box.center()[axis], r.index); };
    const auto at = [](std::vector<Record>& v, std::uint32_t i) { return v.begin() + std::ptrdiff_t{i}; };
    std::copy(at(records_, task.first), at(records_, task.last), at(scratch_, task.first));
    const std::uint32_t half = task.first + (task.last - task.first) / 2;
    std::nth_element(at(scratch_, task.first), at(scratch_, half), at(scratch_, task.last),
                     [&](const Record& a, const Record& b) { return key(a) < key(b); });
    const auto median = key(scratch_[half]);
    return distribute(task, [&](const Record& r) { return key(r) < median ? 1U : 2U; });
  }

  Parts octreeParts(const Task& task) {
    const Vec3 plane = task.cell.center();
    return distribute(task, [&](const Record& r) {
      unsigned octant = 0;
      for (int k = 0; k < 3; ++k) {
        if (r.box.max[k] <= plane[k]) continue;
        if (r.box.min[k] < plane[k]) return 0U;
        octant |= 1U << k;
      }
      return 1 + octant;
    });
  }

  /// A cell's loose box reaches half a side beyond it, so it holds what is centred in it and no larger than
  /// its side. An item larger than half the side is too large for the next level and stays.
  Parts looseParts(const Task& task) {
    const Vec3 plane = task.cell.center();
    const double childSide = std::ldexp(looseSide_, -1 - static_cast<int>(task.level));
    return distribute(task, [&](const Record& r) {
      if (!((r.box.max - r.box.min).maxCoeff() <= childSide)) return 0U;
      const Vec3 center = r.box.center();
      unsigned octant = 0;
      for (int k = 0; k < 3; ++k)
        octant |= center[k] < plane[k] ? 0U : 1U << k;
      return 1 + octant;
    });
  }

  Parts kdParts(const Task& task) {
    const int axis = longestAxis(task.cell);
    const double plane = middle(task.cell.min[axis], task.cell.max[axis]);
    return distribute(task, [&](const Record& r) {
      if (r.box.max[axis] <= plane) return 1U;
      return r.box.min[axis] < plane ? 0U : 2U;
    });
  }

  /// Sorts the range by part, stably: the order of the input is the tie-break everywhere.
  template <class PartOf>
  Parts distribute(const Task& task, PartOf partOf) {
    std::array<std::uint32_t, kMaxParts> sizes{};
    for (std::uint32_t i = task.first; i < task.last; ++i) {
      const unsigned part = partOf(records_[i]);
      parts_[i] = static_cast<std::uint8_t>(part);
      ++sizes[part];
    }
    Parts parts;
    parts.begin[0] = task.first;
    for (std::size_t part = 0; part < kMaxParts; ++part)
      parts.begin[part + 1] = parts.begin[part] + sizes[part];
    if (std::ranges::find(sizes, task.last - task.first) != sizes.end()) return parts;
    auto next = parts.begin;
    for (std::uint32_t i = task.first; i < task.last; ++i)
      scratch_[next[parts_[i]]++] = records_[i];
    std::copy(scratch_.begin() + std::ptrdiff_t{task.first}, scratch_.begin() + std::ptrdiff_t{task.last},
              records_.begin() + std::ptrdiff_t{task.first});
    return parts;
  }

  std::span<const Bounds> items_;
  std::span<const std::uint64_t> triangles_;
  std::uint64_t maxTriangles_;
  HierarchyKind kind_;
  double looseSide_ = 0;
  std::vector<Record> records_, scratch_;
  std::vector<std::uint8_t> parts_;
  std::vector<Task> tasks_;
  std::vector<Bounds> group_;
  ObjectHierarchyBuilder builder_;
};

}  // namespace

std::optional<HierarchyKind> hierarchyFromName(std::string_view name) {
  for (const auto& [kind, text] : kNames) {
    if (text == name) return kind;
  }
  return std::nullopt;
}

std::string_view nameOf(HierarchyKind kind) {
  return kNames[static_cast<std::size_t>(kind)].second;
}

SpatialHierarchy buildSpatialHierarchy(HierarchyKind kind, std::span<const Bounds> items,
                                       std::span<const std::uint64_t> triangles,
                                       std::uint64_t maxTrianglesPerLeaf) {
  // A tree has fewer nodes than twice its leaves, and their numbers have 32 bits.
  if (kind == HierarchyKind::Graph || items.size() != triangles.size() || items.size() > UINT32_MAX / 2)
    std::abort();
  return SpatialBuilder(kind, items, triangles, maxTrianglesPerLeaf).build();
}

}  // namespace tessera

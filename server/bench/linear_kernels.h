#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/object_hierarchy.h"
#include "common/hierarchy/visible_list.h"

namespace tessera::bench {

/// Leaf ids as 32-bit numbers, all tiles' lists one after the other.
class LeafIds {
 public:
  /// Makes room, so that write() does not allocate.
  void reserve(std::uint64_t pairs);
  /// Writes out every list; reserve() must have been called for as many pairs.
  void write(const std::vector<VisibleList>& lists);
  /// Of the last write().
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] std::uint32_t operator[](std::uint64_t i) const { return ids_[i]; }

 private:
  std::vector<std::uint32_t> ids_;
  std::uint64_t count_ = 0;
};

/// The sum of all numbers of all oriented boxes, read once in the order of the nodes: what a culler that
/// looks at everything could not be faster than.
[[nodiscard]] double sumOfObbs(const ObjectHierarchy& oh);

}  // namespace tessera::bench

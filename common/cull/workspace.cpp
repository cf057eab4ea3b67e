#include "common/cull/workspace.h"

#include <algorithm>

namespace tessera::cull {

void Context::emit(std::uint32_t tile, std::uint32_t node) const {
  VisibleList& list = work.result.lists[tile];
  const LeafRange range = oh.leaves(node);
  if (list.empty() || range.first >= list.back().last) {
    appendRange(list, range);
  } else if (range.first < list.back().first || range.last > list.back().last) {
    list.push_back(range);
    work.isUnordered = true;
  }  // else: known already, by way of another half of FH
}

void Context::pushChildren(const Task& task, std::uint32_t mask) const {
  std::vector<Task>& tasks = work.tasks;
  const std::size_t start = tasks.size();
  const std::uint32_t end = oh.subtreeEnd(task.node);
  for (std::uint32_t child = task.node + 1; child != end; child = oh.subtreeEnd(child)) {
    tasks.push_back({.node = child, .frustum = task.frustum, .mask = mask, .isTile = task.isTile});
  }
  std::reverse(tasks.begin() + static_cast<std::ptrdiff_t>(start), tasks.end());
}

void finishLists(Workspace& work) {
  if (!work.isUnordered) return;
  work.isUnordered = false;
  for (VisibleList& list : work.result.lists) {
    std::sort(list.begin(), list.end(), [](LeafRange a, LeafRange b) { return a.first < b.first; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (kept > 0 && list[i].first <= list[kept - 1].last) {
        list[kept - 1].last = std::max(list[kept - 1].last, list[i].last);
      } else {
        list[kept++] = list[i];
      }
    }
    list.resize(kept);
  }
}

}  // namespace tessera::cull

#include "common/scene/scene.h"

#include <algorithm>

namespace tessera {

std::uint64_t Scene::triangleCount() const {
  std::uint64_t count = 0;
  for (const SceneLeaf& leaf : leaves)
    count += leaf.triangles;
  return count;
}

std::uint32_t Scene::addPathNode(std::uint32_t parent, std::uint32_t childIndex, std::string_view name) {
  const auto number = static_cast<std::uint32_t>(pathNodes.size());
  pathNodes.push_back({.parent = parent,
                       .childIndex = childIndex,
                       .nameBegin = static_cast<std::uint32_t>(names.size()),
                       .nameBytes = static_cast<std::uint32_t>(name.size())});
  names.append(name.begin(), name.end());
  return number;
}

std::string Scene::pathOfNode(std::uint32_t pathNode) const {
  std::vector<std::string_view> parts;
  for (std::uint32_t node = pathNode;; node = pathNodes[node].parent) {
    parts.push_back(nameOf(pathNodes[node]));
    if (pathNodes[node].parent == node) break;
  }
  std::string path;
  for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
    if (!path.empty()) path += '/';
    path += *part;
  }
  return path;
}

std::vector<std::uint32_t> Scene::nodePathOf(std::uint32_t leaf) const {
  std::vector<std::uint32_t> path;
  if (isGltf) return path;
  for (std::uint32_t node = leaves[leaf].pathNode; node != 0; node = pathNodes[node].parent)
    path.push_back(pathNodes[node].childIndex);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace tessera

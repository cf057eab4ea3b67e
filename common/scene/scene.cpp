#include "common/scene/scene.h"

namespace tessera {

std::uint64_t Scene::triangleCount() const {
  std::uint64_t count = 0;
  for (const SceneLeaf& leaf : leaves)
    count += leaf.triangles;
  return count;
}

std::string Scene::pathOf(std::uint32_t leaf) const {
  std::vector<const std::string*> names;
  for (std::uint32_t node = leaves[leaf].pathNode;; node = pathNodes[node].parent) {
    names.push_back(&pathNodes[node].name);
    if (pathNodes[node].parent == node) break;
  }
  std::string path;
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    if (!path.empty()) path += '/';
    path += **name;
  }
  return path;
}

}  // namespace tessera

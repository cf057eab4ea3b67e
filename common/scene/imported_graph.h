#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <osg/Group>
#include <osg/ref_ptr>

#include "common/scene/motion/motion.h"

namespace tessera {

/// Where a graph node came from in its glTF file.
struct GltfSource {
  int node = -1;                ///< index of the glTF node
  std::vector<int> primitives;  ///< primitives[i]: index of the glTF primitive of the i-th drawable child
};

/// A scene read into memory, as its file has it: y up where the file is y up, nothing moved.
struct ImportedGraph {
  osg::ref_ptr<osg::Group> root;
  std::unordered_map<const osg::Node*, GltfSource> gltfSources;  ///< empty for other formats
  std::vector<std::string> warnings;                             ///< one sentence each
  std::set<std::filesystem::path> files;   ///< looked for beside the named one, whether they are there or not
  motion::Motion motion;                   ///< of glTF: nodes, channels and skins, no leaves yet
  std::vector<std::uint32_t> motionNodes;  ///< by glTF node: its place in motion.nodes; empty or kNone: none
  std::vector<std::uint32_t> motionSkins;  ///< by node of the motion: its skin, or kNone

  ImportedGraph() = default;
  ImportedGraph(ImportedGraph&&) = default;
  ImportedGraph& operator=(ImportedGraph&& other) noexcept {
    std::swap(root, other.root);
    std::swap(gltfSources, other.gltfSources);
    std::swap(warnings, other.warnings);
    std::swap(files, other.files);
    std::swap(motion, other.motion);
    std::swap(motionNodes, other.motionNodes);
    std::swap(motionSkins, other.motionSkins);
    return *this;
  }
  ImportedGraph(const ImportedGraph&) = delete;
  ImportedGraph& operator=(const ImportedGraph&) = delete;
  /// Takes the graph apart level by level: the destructors of OSG recurse, and a deep tree would overflow the
  /// stack. What others still hold stays whole.
  ~ImportedGraph() {
    std::vector<osg::ref_ptr<osg::Node>> dying;
    if (root) dying.emplace_back(root);
    root = nullptr;
    while (!dying.empty()) {
      const osg::ref_ptr<osg::Node> node = dying.back();
      dying.pop_back();
      osg::Group* group = node->asGroup();
      if (node->referenceCount() > 1 || group == nullptr) continue;
      for (unsigned int i = 0; i < group->getNumChildren(); ++i)
        dying.emplace_back(group->getChild(i));
      group->removeChildren(0, group->getNumChildren());
    }
  }
};

}  // namespace tessera

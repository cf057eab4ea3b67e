#include "common/scene/gltf/node_tree.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <osg/MatrixTransform>
#include <osg/Quat>

#include "common/scene/gltf/motion_reader.h"

namespace tessera::gltf {

namespace {

constexpr const char* kExportAgain = "export it again";
constexpr int kNoParent = -1;

std::string nodeName(std::size_t index) {
  return "node " + std::to_string(index);
}

bool areFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// The parent of each node. Refuses children out of range, two parents, cycles.
Result<std::vector<int>> parentsOf(const std::vector<tinygltf::Node>& nodes) {
  std::vector<int> parents(nodes.size(), kNoParent);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const int child : nodes[i].children) {
      if (child < 0 || static_cast<std::size_t>(child) >= nodes.size()) {
        return inputError({}, nodeName(i) + " has child " + std::to_string(child) + ", which does not exist",
                          kExportAgain);
      }
      int& parent = parents[static_cast<std::size_t>(child)];
      if (parent != kNoParent) {
        return inputError({},
                          "node " + std::to_string(child) + " has two parents, nodes " +
                              std::to_string(parent) + " and " + std::to_string(i),
                          kExportAgain);
      }
      parent = static_cast<int>(i);
    }
  }
  // With one parent each, a node that no root leads to lies on or below a cycle.
  std::vector<bool> isReached(nodes.size(), false);
  std::vector<int> open;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (parents[i] == kNoParent) open.push_back(static_cast<int>(i));
  }
  while (!open.empty()) {
    const auto at = static_cast<std::size_t>(open.back());
    open.pop_back();
    isReached[at] = true;
    open.insert(open.end(), nodes[at].children.begin(), nodes[at].children.end());
  }
  const auto lost = std::find(isReached.begin(), isReached.end(), false);
  if (lost == isReached.end()) return parents;
  return inputError({},
                    nodeName(static_cast<std::size_t>(lost - isReached.begin())) +
                        " is its own ancestor, or lies below such a node",
                    kExportAgain);
}

/// What is wrong with a scene's list of roots at `root`; empty where nothing is.
std::string faultOfRoot(int root, const std::vector<int>& parents, std::vector<bool>& isListed) {
  if (root < 0 || static_cast<std::size_t>(root) >= parents.size()) return ", which does not exist";
  const auto at = static_cast<std::size_t>(root);
  if (isListed[at]) return " twice";
  isListed[at] = true;
  if (parents[at] != kNoParent) return ", which is a child of node " + std::to_string(parents[at]);
  return {};
}

Status checkRoots(const std::vector<int>& roots, const std::vector<int>& parents, int scene) {
  std::vector<bool> isListed(parents.size(), false);
  for (const int root : roots) {
    const std::string fault = faultOfRoot(root, parents, isListed);
    if (fault.empty()) continue;
    return inputError({}, "scene " + std::to_string(scene) + " lists node " + std::to_string(root) + fault,
                      kExportAgain);
  }
  return Done{};
}

struct SceneRoots {
  std::string name;
  std::vector<int> nodes;
};

Result<SceneRoots> rootsOf(const tinygltf::Model& model, const std::vector<int>& parents,
                           Warnings& warnings) {
  if (model.scenes.empty()) {
    if (model.defaultScene > 0) {
      return inputError({}, "scene " + std::to_string(model.defaultScene) + " does not exist", kExportAgain);
    }
    warnings.add("no scene", "the file names no scene; all its nodes without a parent are drawn");
    SceneRoots roots;
    for (std::size_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNoParent) roots.nodes.push_back(static_cast<int>(i));
    }
    return roots;
  }
  const int scene = std::max(model.defaultScene, 0);
  if (static_cast<std::size_t>(scene) >= model.scenes.size()) {
    return inputError({}, "scene " + std::to_string(scene) + " does not exist", kExportAgain);
  }
  const tinygltf::Scene& source = model.scenes[static_cast<std::size_t>(scene)];
  const Status status = checkRoots(source.nodes, parents, scene);
  if (!status) return status.error();
  return SceneRoots{source.name, source.nodes};
}

Result<osg::Matrixd> fromMatrix(const std::vector<double>& m) {
  if (m.size() != 16) return inputError({}, "has a matrix that is not 16 numbers", kExportAgain);
  if (!areFinite(m)) return inputError({}, "has a matrix that is not finite", kExportAgain);
  constexpr double kSlack = 1e-6;  // of exporters that divide a projective matrix out
  if (std::abs(m[3]) > kSlack || std::abs(m[7]) > kSlack || std::abs(m[11]) > kSlack ||
      std::abs(m[15] - 1) > kSlack) {
    return inputError({}, "has a matrix that does more than turn, stretch and move", kExportAgain);
  }
  // Column-major for column vectors is what OSG's row vectors want row by row.
  return osg::Matrixd(m[0], m[1], m[2], 0, m[4], m[5], m[6], 0, m[8], m[9], m[10], 0, m[12], m[13], m[14], 1);
}

Result<osg::Matrixd> fromParts(const tinygltf::Node& node, std::size_t index, Warnings& warnings) {
  const bool isComplete = (node.translation.empty() || node.translation.size() == 3) &&
                          (node.scale.empty() || node.scale.size() == 3) &&
                          (node.rotation.empty() || node.rotation.size() == 4);
  if (!isComplete)
    return inputError({}, "has a translation, rotation or scale of the wrong length", kExportAgain);
  if (!areFinite(node.translation) || !areFinite(node.scale) || !areFinite(node.rotation)) {
    return inputError({}, "has a translation, rotation or scale that is not finite", kExportAgain);
  }
  osg::Matrixd matrix;
  if (!node.scale.empty()) matrix.makeScale(node.scale[0], node.scale[1], node.scale[2]);
  if (!node.rotation.empty()) {
    osg::Quat turn(node.rotation[0], node.rotation[1], node.rotation[2], node.rotation[3]);
    const double length = std::hypot(std::hypot(turn.x(), turn.y()), std::hypot(turn.z(), turn.w()));
    if (!(length > 0) || !std::isfinite(length)) {
      return inputError({}, "has a rotation without direction (a zero quaternion)", kExportAgain);
    }
    if (std::abs(length - 1) > 1e-3) {
      warnings.add("rotation normalized", nodeName(index) + " has a rotation of length " +
                                              std::to_string(length) + "; it is taken as of length 1");
    }
    matrix.postMultRotate(turn / length);
  }
  if (!node.translation.empty()) {
    matrix.postMultTranslate(osg::Vec3d(node.translation[0], node.translation[1], node.translation[2]));
  }
  return matrix;
}

Result<osg::Matrixd> localMatrix(const tinygltf::Node& node, std::size_t index, Warnings& warnings) {
  Result<osg::Matrixd> matrix =
      node.matrix.empty() ? fromParts(node, index, warnings) : fromMatrix(node.matrix);
  if (!matrix) return inputError({}, nodeName(index) + " " + matrix.error().what, matrix.error().mend);
  if (matrix->isNaN() ||
      !std::all_of(matrix->ptr(), matrix->ptr() + 16, [](double v) { return std::isfinite(v); })) {
    return inputError({}, nodeName(index) + " has a transform that is not finite", kExportAgain);
  }
  return matrix;
}

bool mirrors(const osg::Matrixd& m) {
  double largest = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      largest = std::max(largest, std::abs(m(r, c)));
  }
  if (largest == 0) return false;
  // Divided first, so that tiny or huge scales neither vanish nor overflow.
  const osg::Vec3d x = osg::Vec3d(m(0, 0), m(0, 1), m(0, 2)) / largest;
  const osg::Vec3d y = osg::Vec3d(m(1, 0), m(1, 1), m(1, 2)) / largest;
  const osg::Vec3d z = osg::Vec3d(m(2, 0), m(2, 1), m(2, 2)) / largest;
  return (x ^ y) * z < 0;
}

/// A node still to be built.
struct Task {
  int node = 0;
  osg::Group* parent = nullptr;
  bool isMirrored = false;
};

void pushAll(std::vector<Task>& tasks, const std::vector<int>& nodes, osg::Group* parent, bool isMirrored) {
  for (auto it = nodes.rbegin(); it != nodes.rend(); ++it)
    tasks.push_back({*it, parent, isMirrored});
}

}  // namespace

Status buildNodes(const Document& document, Geometries& geometries, Warnings& warnings,
                  ImportedGraph& graph) {
  const tinygltf::Model& model = document.model;
  const Result<std::vector<int>> parents = parentsOf(model.nodes);
  if (!parents) return parents.error();
  const Result<SceneRoots> roots = rootsOf(model, *parents, warnings);
  if (!roots) return roots.error();
  graph.root = new osg::Group;
  graph.root->setName(roots->name);
  graph.gltfSources.reserve(model.nodes.size());

  std::vector<Task> tasks;
  pushAll(tasks, roots->nodes, graph.root, false);
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const auto index = static_cast<std::size_t>(task.node);
    const tinygltf::Node& source = model.nodes[index];
    const Result<osg::Matrixd> matrix = localMatrix(source, index, warnings);
    if (!matrix) return matrix.error();
    const osg::ref_ptr<osg::Group> group =
        matrix->isIdentity() ? new osg::Group : new osg::MatrixTransform(*matrix);
    group->setName(source.name);
    task.parent->addChild(group);
    const bool isMirrored = task.isMirrored != mirrors(*matrix);

    GltfSource& origin = graph.gltfSources[group];
    origin.node = task.node;
    if (source.mesh >= 0) {
      const Result<const std::vector<Leaf>*> leaves = geometries.leaves(source.mesh, isMirrored);
      if (!leaves) return inputError({}, nodeName(index) + ": " + leaves.error().what, leaves.error().mend);
      for (const Leaf& leaf : **leaves) {
        group->addChild(leaf.geometry);
        origin.primitives.push_back(leaf.primitiveIndex);
      }
    }
    pushAll(tasks, source.children, group, isMirrored);
  }
  readMotion(document, geometries.accessors(), roots->nodes, warnings, graph);
  return Done{};
}

}  // namespace tessera::gltf

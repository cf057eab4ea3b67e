#include "common/scene/motion/skeleton_player.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <osg/FrameStamp>
#include <osg/Group>
#include <osg/LOD>
#include <osg/Sequence>
#include <osg/Switch>
#include <osg/Transform>
#include <osgUtil/UpdateVisitor>

#include "common/scene/osgb_codec.h"

namespace tessera::motion {

struct SkeletonPlayer::Graph {
  struct Node {
    osg::ref_ptr<osg::Node> node;
    std::uint32_t parent = 0;  ///< the root is its own
    std::uint32_t childIndex = 0;
    Mat4 world = Mat4::Identity();
    bool isShown = true;
  };

  void place(Node& node);
  [[nodiscard]] bool isChosen(const Node& parent, std::uint32_t child) const;

  std::vector<Node> nodes;  ///< in pre-order
  osg::ref_ptr<osgUtil::UpdateVisitor> update = new osgUtil::UpdateVisitor;
  osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
  unsigned int frame = 0;
  Vec3 eye = Vec3::Zero();
};

void SkeletonPlayer::Graph::place(Node& node) {
  const Node& parent = nodes[node.parent];
  const bool isRoot = &parent == &node;
  const osg::Transform* transform = node.node->asTransform();
  Mat4 local = Mat4::Identity();
  if (transform) {
    osg::Matrixd matrix;
    transform->computeLocalToWorldMatrix(matrix, nullptr);
    local = Eigen::Map<const Mat4>(matrix.ptr());
  }
  node.world = isRoot ? local : parent.world * local;
  node.isShown = isRoot || (parent.isShown && isChosen(parent, node.childIndex));
}

bool SkeletonPlayer::Graph::isChosen(const Node& parent, std::uint32_t child) const {
  if (const auto* choice = dynamic_cast<const osg::Switch*>(parent.node.get()))
    return choice->getValue(child);
  if (const auto* sequence = dynamic_cast<const osg::Sequence*>(parent.node.get()))
    return static_cast<int>(child) == std::max(sequence->getValue(), 0);
  const auto* lod = dynamic_cast<const osg::LOD*>(parent.node.get());
  if (!lod) return true;
  double range = 0;
  if (lod->getRangeMode() == osg::LOD::PIXEL_SIZE_ON_SCREEN) {
    // One choice for the whole wall, whose pixels differ: the finest.
    for (const auto& [least, most] : lod->getRangeList())
      range = std::max(range, static_cast<double>(least));
  } else {
    const osg::LOD::vec_type& center = lod->getCenter();
    const Vec3 local = (parent.world.inverse() * eye.homogeneous()).head<3>();
    range = (local - Vec3(center.x(), center.y(), center.z())).norm();
  }
  return child < lod->getRangeList().size() && static_cast<double>(lod->getMinRange(child)) <= range &&
         range < static_cast<double>(lod->getMaxRange(child));
}

SkeletonPlayer::SkeletonPlayer(std::unique_ptr<Graph> graph) : graph_(std::move(graph)) {}
SkeletonPlayer::~SkeletonPlayer() = default;

Result<std::unique_ptr<SkeletonPlayer>> SkeletonPlayer::read(std::string_view osgb) {
  const auto object = OsgbCodec().read(osgb, [](const std::string&) { return osg::ref_ptr<osg::Image>(); });
  if (!object) return runtimeError("scene motion", object.error().what, "build the scene's index again");
  osg::ref_ptr<osg::Node> root = dynamic_cast<osg::Node*>(object->get());
  if (!root) return runtimeError("scene motion", "holds no graph", "build the scene's index again");
  auto graph = std::make_unique<Graph>();
  std::vector<Graph::Node> open(1);
  open[0].node = root;
  while (!open.empty()) {
    Graph::Node node = open.back();
    open.pop_back();
    const auto number = static_cast<std::uint32_t>(graph->nodes.size());
    const osg::Group* group = node.node->asGroup();
    for (unsigned int i = group ? group->getNumChildren() : 0; i-- > 0;) {
      Graph::Node& child = open.emplace_back();
      child.node = const_cast<osg::Node*>(group->getChild(i));
      child.parent = number;
      child.childIndex = i;
    }
    graph->nodes.push_back(std::move(node));
  }
  graph->update->setFrameStamp(graph->stamp);
  // All the time, also where nobody looks: what comes back is then where it belongs.
  graph->update->setTraversalMode(osg::NodeVisitor::TRAVERSE_ALL_CHILDREN);
  return std::unique_ptr<SkeletonPlayer>(new SkeletonPlayer(std::move(graph)));
}

void SkeletonPlayer::advance(double timeS, const Vec3& eye, bool animates) {
  Graph& graph = *graph_;
  graph.eye = eye;
  if (animates) {
    graph.stamp->setFrameNumber(++graph.frame);
    graph.stamp->setReferenceTime(timeS);
    graph.stamp->setSimulationTime(timeS);
    graph.update->setTraversalNumber(graph.frame);
    graph.nodes[0].node->accept(*graph.update);
  }
  for (Graph::Node& node : graph.nodes)
    graph.place(node);
}

std::uint32_t SkeletonPlayer::nodeCount() const {
  return static_cast<std::uint32_t>(graph_->nodes.size());
}
const Mat4& SkeletonPlayer::world(std::uint32_t node) const {
  return graph_->nodes[node].world;
}
bool SkeletonPlayer::isShown(std::uint32_t node) const {
  return graph_->nodes[node].isShown;
}

}  // namespace tessera::motion

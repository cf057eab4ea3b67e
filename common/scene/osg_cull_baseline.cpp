#include "common/scene/osg_cull_baseline.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <osg/Billboard>
#include <osg/LOD>
#include <osg/LightSource>
#include <osg/Switch>
#include <osgUtil/CullVisitor>
#include <osgUtil/RenderStage>
#include <osgUtil/StateGraph>

#include "common/scene/import_graph.h"

namespace tessera {

namespace {

/// OSG's traversals recurse on the machine stack.
constexpr std::size_t kMaxDepth = 10'000;

constexpr osg::CullSettings::CullingMode kSixPlanes = osg::CullSettings::VIEW_FRUSTUM_SIDES_CULLING |
                                                      osg::CullSettings::NEAR_PLANE_CULLING |
                                                      osg::CullSettings::FAR_PLANE_CULLING;

/// The frustum tests of CullVisitor without what it does with the outcome.
class CountingVisitor : public osgUtil::CullVisitor {
 public:
  std::uint64_t passed = 0;

  void apply(osg::Node& node) override { descend(node); }
  void apply(osg::Geode& node) override { descend(node); }
  void apply(osg::Group& node) override { descend(node); }
  void apply(osg::LightSource& node) override { descend(node); }
  void apply(osg::Switch& node) override { descend(node); }
  void apply(osg::LOD& node) override { descend(node); }
  void apply(osg::Camera&) override {}  // no part of the scene, as on import
  void apply(osg::Transform& node) override {
    if (isCulled(node)) return;
    pushCurrentMask();
    osg::RefMatrix* matrix = createOrReuseMatrix(*getModelViewMatrix());
    node.computeLocalToWorldMatrix(*matrix, this);
    pushModelViewMatrix(matrix, node.getReferenceFrame());
    traverse(node);
    popModelViewMatrix();
    popCurrentMask();
  }
  void apply(osg::Drawable& drawable) override {
    if (drawable.isCullingActive() && isCulled(drawable.getBoundingBox())) return;
    ++passed;
  }
  void apply(osg::Billboard& node) override {
    if (!isCulled(node)) passed += node.getNumDrawables();
  }

 private:
  void descend(osg::Node& node) {
    if (isCulled(node)) return;
    pushCurrentMask();
    traverse(node);
    popCurrentMask();
  }
};

osg::Matrixd viewMatrixOf(const WallView& view) {
  Mat4 m = Mat4::Identity();
  m.row(0).head<3>() = view.axes[0].right.transpose();
  m.row(1).head<3>() = view.axes[0].up.transpose();
  m.row(2).head<3>() = view.axes[0].right.cross(view.axes[0].up).transpose();  // towards the eye
  m.topRightCorner<3, 1>() = -(m.topLeftCorner<3, 3>() * view.screens[0].eye);
  osg::Matrixd out;
  Eigen::Map<Mat4>(out.ptr()) = m;  // see toColumnVectors in common/scene/extract.cpp
  return out;
}

osg::Matrixd projectionOf(const Frustum& tile, const WallView& view) {
  Mat3 rotation;
  rotation.row(0) = view.axes[0].right.transpose();
  rotation.row(1) = view.axes[0].up.transpose();
  rotation.row(2) = view.axes[0].right.cross(view.axes[0].up).transpose();
  const Vec3 lowerLeft = rotation * (tile.corners[0] - tile.eye);
  const Vec3 upperRight = rotation * (tile.corners[2] - tile.eye);
  const double near = *tile.near, left = near / -lowerLeft.z(), right = near / -upperRight.z();
  return osg::Matrixd::frustum(lowerLeft.x() * left, upperRight.x() * right, lowerLeft.y() * left,
                               upperRight.y() * right, near, *tile.far);
}

std::uint64_t leavesBelow(const osgUtil::StateGraph& graph) {
  std::uint64_t count = graph._leaves.size();
  for (const auto& [state, child] : graph._children)
    count += leavesBelow(*child);
  return count;
}

bool isDeeperThan(osg::Node& root, std::size_t limit) {
  std::vector<osg::Node*> level = {&root}, next;
  for (std::size_t depth = 0; !level.empty(); ++depth) {
    if (depth > limit) return true;
    next.clear();
    for (osg::Node* node : level) {
      osg::Group* group = node->asGroup();
      for (unsigned int i = 0; group && i < group->getNumChildren(); ++i)
        next.push_back(group->getChild(i));
    }
    // A node with several parents counts once on each level.
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    level.swap(next);
  }
  return false;
}

/// Drawables keep theirs apart from their nodes'.
class ComputeBounds : public osg::NodeVisitor {
 public:
  ComputeBounds() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
  void apply(osg::Node& node) override {
    node.getBound();
    traverse(node);
  }
  void apply(osg::Drawable& drawable) override { drawable.getBoundingBox(); }
};

/// What one tile's viewer keeps from frame to frame.
struct TileViewer {
  osg::ref_ptr<osgUtil::CullVisitor> full = osgUtil::CullVisitor::create();
  osg::ref_ptr<CountingVisitor> counting = new CountingVisitor;
  osg::ref_ptr<osgUtil::StateGraph> states = new osgUtil::StateGraph;
  osg::ref_ptr<osgUtil::RenderStage> stage = new osgUtil::RenderStage;
  osg::ref_ptr<osg::RefMatrix> projection = new osg::RefMatrix;
};

}  // namespace

struct OsgCullBaseline::Impl {
  ImportedGraph graph;
  std::vector<TileViewer> tiles;
  osg::ref_ptr<osg::RefMatrix> view = new osg::RefMatrix;
  osg::ref_ptr<osg::Viewport> viewport = new osg::Viewport(0, 0, 480, 270);
  osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;

  void traverse(osgUtil::CullVisitor& visitor, const TileViewer& tile) {
    visitor.reset();
    visitor.pushViewport(viewport);
    visitor.pushProjectionMatrix(tile.projection);
    visitor.pushModelViewMatrix(view, osg::Transform::ABSOLUTE_RF);
    graph.root->accept(visitor);
    visitor.popModelViewMatrix();
    visitor.popProjectionMatrix();
    visitor.popViewport();
  }
};

OsgCullBaseline::OsgCullBaseline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OsgCullBaseline::~OsgCullBaseline() = default;
OsgCullBaseline::OsgCullBaseline(OsgCullBaseline&&) noexcept = default;
OsgCullBaseline& OsgCullBaseline::operator=(OsgCullBaseline&&) noexcept = default;

Result<OsgCullBaseline> OsgCullBaseline::read(const std::filesystem::path& path, UpAxis up) {
  auto graph = importGraph(path, up);
  if (!graph) return graph.error();
  if (isDeeperThan(*graph->root, kMaxDepth)) {
    return inputError(path.string(), "is too deep a tree for OpenSceneGraph's traversal",
                      "leave out the candidates named osg");
  }
  auto impl = std::make_unique<Impl>();
  impl->graph = std::move(*graph);
  ComputeBounds compute;
  impl->graph.root->accept(compute);
  return OsgCullBaseline(std::move(impl));
}

void OsgCullBaseline::setView(const WallView& view) {
  impl_->tiles.resize(view.tiles.size());
  impl_->view->set(viewMatrixOf(view));
  for (std::size_t i = 0; i < view.tiles.size(); ++i) {
    TileViewer& tile = impl_->tiles[i];
    tile.projection->set(projectionOf(view.tiles[i], view));
    for (osgUtil::CullVisitor* visitor :
         {tile.full.get(), static_cast<osgUtil::CullVisitor*>(tile.counting.get())}) {
      visitor->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
      visitor->setCullingMode(kSixPlanes);
      visitor->setFrameStamp(impl_->stamp);
    }
    tile.full->setStateGraph(tile.states);
    tile.full->setRenderStage(tile.stage);
  }
}

void OsgCullBaseline::cullFull() {
  for (const TileViewer& tile : impl_->tiles) {  // as osgUtil::SceneView::cullStage
    tile.states->clean();
    tile.stage->reset();
    tile.stage->setViewport(impl_->viewport);
    impl_->traverse(*tile.full, tile);
    tile.stage->sort();
    tile.states->prune();
  }
}

void OsgCullBaseline::cullTraversalOnly() {
  for (const TileViewer& tile : impl_->tiles) {
    tile.counting->passed = 0;
    impl_->traverse(*tile.counting, tile);
  }
}

std::uint64_t OsgCullBaseline::fullPairs() const {
  std::uint64_t pairs = 0;
  for (const TileViewer& tile : impl_->tiles)
    pairs += leavesBelow(*tile.states);
  return pairs;
}

std::uint64_t OsgCullBaseline::traversalPairs() const {
  std::uint64_t pairs = 0;
  for (const TileViewer& tile : impl_->tiles)
    pairs += tile.counting->passed;
  return pairs;
}

}  // namespace tessera

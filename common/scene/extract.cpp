#include "common/scene/extract.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <unordered_map>

#include <Eigen/Geometry>
#include <osg/Billboard>
#include <osg/Camera>
#include <osg/LOD>
#include <osg/LightSource>
#include <osg/NodeVisitor>
#include <osg/Transform>

#include "common/scene/asset_writer.h"
#include "common/scene/cut_drawable.h"
#include "common/scene/motion/motion_codec.h"
#include "common/scene/motion_notes.h"

namespace tessera {

namespace {

/// Notes the children that a node would traverse, without going further down.
class ActiveChildren : public osg::NodeVisitor {
 public:
  ActiveChildren() : osg::NodeVisitor(TRAVERSE_ACTIVE_CHILDREN) {}
  void apply(osg::Node& node) override { children.push_back(&node); }
  std::vector<osg::Node*> children;
};

/// A transform from local to world with a bound of its rounding: every entry of the exact product of the
/// chain differs from `matrix` by at most steps * 8u * `absolute`. A product of two 4x4 matrices errs by 4u
/// of the product of the absolute values; as much again is kept for the rounding of the factors themselves,
/// which may come from a rotation.
struct WorldTransform {
  Mat4 matrix = Mat4::Identity();
  Mat4 absolute = Mat4::Identity();
  int steps = 1;

  [[nodiscard]] WorldTransform then(const Mat4& local) const {
    return {matrix * local, absolute * local.cwiseAbs(), steps + 1};
  }
  /// Bound of the error of any transformed point with |p| <= `reach` per component.
  [[nodiscard]] Vec3 errorAt(const Vec3& reach) const {
    return (absolute * reach.homogeneous()).head<3>() * (8.0 * (steps + 1) * kUnitRoundoff);
  }
  /// What an error of up to `error` in each component of a point may come to.
  [[nodiscard]] Vec3 spread(const Vec3& error) const { return absolute.topLeftCorner<3, 3>() * error; }
};

Mat4 toColumnVectors(const osg::Matrixd& m) {
  // OSG's row-major matrix for row vectors is, read column by column, the same map for column vectors.
  return Eigen::Map<const Mat4>(m.ptr());
}

Vec3 toVec3(const osg::Vec3d& v) {
  return {v.x(), v.y(), v.z()};
}

std::array<std::uint8_t, 4> meanRgba(const std::optional<osg::Vec4>& ofVertices, const StateColor& ofState) {
  osg::Vec4 color = ofVertices ? *ofVertices : ofState.material;
  color = osg::componentMultiply(color, ofState.texture);
  std::array<std::uint8_t, 4> rgba{};
  for (unsigned int i = 0; i < 4; ++i) {
    const float channel = color[i] >= 0 ? std::min(color[i], 1.0F) : 0.0F;  // a NaN is no colour
    rgba[i] = static_cast<std::uint8_t>(std::lround(channel * 255));
  }
  return rgba;
}

class Extractor {
 public:
  Extractor(const ImportedGraph& graph, Scene& scene, const ExtractOptions& options)
      : graph_(graph),
        scene_(scene),
        options_(options),
        maxTriangles_(options.maxTrianglesPerLeaf),
        writer_(scene.assets),
        notes_(graph) {}

  Status run() {
    scene_.addPathNode(0, 0, "root");
    visits_.push_back({.node = graph_.root.get()});
    while (!visits_.empty()) {
      Visit visit = std::move(visits_.back());
      visits_.pop_back();
      if (!visit.node) {
        builder_.closeNode();
        if (notes_.mayHide()) shown_.closeNode();
        notes_.leave(visit.place, visit.isParentHidden, scene_.graphLeafCount);
        continue;
      }
      if (Status status = enter(visit); !status) return status;
      tellProgress();
    }
    scene_.hierarchy = builder_.finish();
    Result<motion::Motion> motion = notes_.finish();
    if (!motion) return inputError(scene_.source, motion.error().what);
    if (!motion->hiddenAsLoaded.empty()) {
      const ObjectHierarchy shown = shown_.finish();
      if (!shown.empty()) motion->shownAsLoaded = shown.sphere(0);
    }
    const std::string encoded = motion::encodeMotion(*motion);
    scene_.motion = std::vector<char>(encoded.begin(), encoded.end());
    warned_.insert(notes_.warnings().begin(), notes_.warnings().end());
    scene_.warnings.insert(scene_.warnings.end(), warned_.begin(), warned_.end());
    return Done{};
  }

 private:
  struct Visit {
    const osg::Node* node = nullptr;  ///< null: close the node that is open
    WorldTransform transform = {};
    const osg::StateSet* state = nullptr;
    std::uint32_t parentPath = 0;
    std::uint32_t childIndex = 0;
    const osg::Node* above = nullptr;
    MotionNotes::Place place = {};  ///< of the node above; of one to be closed its own
    bool isParentHidden = false;    ///< of one to be closed
  };

  /// Where a drawable stands.
  struct Place {
    const osg::Node& parent;
    std::uint32_t drawableIndex;  ///< among the parent's drawables
    const WorldTransform& transform;
    const osg::StateSet* inherited;
    std::uint32_t path;
    const MotionNotes::Place& motion;
  };

  /// A drawable in parts. They are stored about the origin of the whole: vertices on a seam then come out the
  /// same on both sides, and as they would uncut.
  struct Cut {
    CutTree tree;
    Vec3 origin = Vec3::Zero();
  };

  /// One leaf's share of a drawable.
  struct Piece {
    bool isShared = false;         ///< it will be met again
    const Vec3* origin = nullptr;  ///< null: its own
    std::uint32_t part = 0;
  };

  /// Of what is found on the way: the number of nodes is not known before.
  void tellProgress() {
    ++nodesDone_;
    if (options_.progress && nodesDone_ % 64 == 0) {
      const auto done = static_cast<double>(nodesDone_);
      options_.progress(done / (done + static_cast<double>(visits_.size())));
    }
  }

  /// Opens a node: its own drawables become leaves, its children are left for later.
  Status enter(const Visit& visit) {
    const osg::Node& node = *visit.node;
    if (skips(node)) return Done{};
    const bool isRoot = visit.node == graph_.root.get();
    const std::uint32_t path = isRoot ? 0 : addPath(visit, node);

    WorldTransform transform = visit.transform;
    const osg::Transform* local = node.asTransform();
    Mat4 m = Mat4::Identity();
    if (local) {
      osg::Matrixd matrix;
      local->computeLocalToWorldMatrix(matrix, nullptr);
      m = toColumnVectors(matrix);
      if (!m.allFinite()) return nodeError(path, "has a matrix with a number that is not finite");
      if (m.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
        return nodeError(path, "has a matrix that is not affine");
      }
      transform = transform.then(m);
      if (!transform.absolute.allFinite()) return nodeError(path, "is scaled beyond the range of numbers");
    }
    const osg::StateSet* state = writer_.merged(visit.state, node.getStateSet());

    builder_.openNode();
    if (notes_.mayHide()) shown_.openNode();
    const MotionNotes::Place place = notes_.enter(node, local ? &m : nullptr, visit.place, visit.above,
                                                  visit.childIndex, scene_.graphLeafCount);
    visits_.push_back({.place = place, .isParentHidden = visit.place.hidden});  // closes it
    const std::size_t firstChild = visits_.size();
    std::uint32_t drawableIndex = 0;
    for (const auto& [i, child] : childrenOf(node)) {
      if (const osg::Drawable* drawable = child->asDrawable()) {
        // One that its parent may choose comes and goes by itself.
        const MotionNotes::Place own =
            choosesChildren(node) ? notes_.enter(*child, nullptr, place, &node, i, scene_.graphLeafCount)
                                  : place;
        const Status status = addDrawable(*drawable, {node, drawableIndex++, transform, state, path, own});
        if (!status) return status;
        if (choosesChildren(node)) notes_.leave(own, place.hidden, scene_.graphLeafCount);
      } else {
        visits_.push_back({.node = child,
                           .transform = transform,
                           .state = state,
                           .parentPath = path,
                           .childIndex = i,
                           .above = &node,
                           .place = place});
      }
    }
    // Last in, first out: the first child must be popped first.
    std::reverse(visits_.begin() + static_cast<std::ptrdiff_t>(firstChild), visits_.end());
    return Done{};
  }

  /// What is traversed below a node: of those that choose everything, also what they do not show now.
  static std::vector<std::pair<std::uint32_t, const osg::Node*>> childrenOf(const osg::Node& node) {
    std::vector<std::pair<std::uint32_t, const osg::Node*>> children;
    const osg::Group* group = node.asGroup();
    if (!group) return children;
    if (choosesChildren(node)) {
      for (unsigned int i = 0; i < group->getNumChildren(); ++i) {
        if (group->getChild(i)->getNodeMask() != 0) children.emplace_back(i, group->getChild(i));
      }
      return children;
    }
    ActiveChildren active;
    const_cast<osg::Group*>(group)->traverse(active);
    for (const osg::Node* child : active.children)
      children.emplace_back(static_cast<std::uint32_t>(children.size()), child);
    return children;
  }

  /// Things that are no part of the scene or cannot be shown; each kind is said once.
  bool skips(const osg::Node& node) {
    if (node.asCamera()) return warn("cameras inside the scene (overlays, pre-render passes) are left out");
    if (dynamic_cast<const osg::LightSource*>(&node)) {
      warn("the scene's own lights are left out: the wall lights all scenes alike");
    }
    if (dynamic_cast<const osg::LOD*>(&node) && !choosesChildren(node))
      warn("of nodes with paged levels of detail the finest level that is there is shown");
    if (const osg::Transform* transform = node.asTransform()) {
      if (transform->getReferenceFrame() != osg::Transform::RELATIVE_RF) {
        return warn("nodes with an absolute reference frame are left out");
      }
    }
    return false;
  }

  bool warn(const std::string& sentence) {
    warned_.insert(sentence);
    return true;
  }

  std::uint32_t addPath(const Visit& visit, const osg::Node& node) {
    std::string name = node.getName();
    if (name.empty()) name = std::string(node.className()) + "[" + std::to_string(visit.childIndex) + "]";
    std::replace(name.begin(), name.end(), '/', '_');
    return scene_.addPathNode(visit.parentPath, visit.childIndex, name);
  }

  /// Adds the drawable as one leaf, or as a subtree of its parts.
  Status addDrawable(const osg::Drawable& drawable, const Place& place) {
    const std::string library = drawable.libraryName();
    if (library == "osgParticle" || library == "osgText") {
      warn("drawables of " + library + " are left out: they change with the frame or the view");
      return Done{};
    }
    const std::size_t before = scene_.leaves.size();
    const bool isShared = drawable.getNumParents() > 1;
    const bool isBillboard = dynamic_cast<const osg::Billboard*>(&place.parent) != nullptr;
    const std::optional<Cut> none, own = isBillboard || isShared ? none : cutOf(drawable);
    const std::optional<Cut>& parts = isBillboard ? none : isShared ? sharedCut(drawable) : own;
    Status status = parts ? addParts(*parts, isShared, place) : addLeaf(drawable, place, {isShared});
    if (scene_.leaves.size() > before) ++scene_.graphLeafCount;
    return status;
  }

  [[nodiscard]] std::optional<Cut> cutOf(const osg::Drawable& drawable) const {
    std::optional<CutTree> tree = cutDrawable(drawable, maxTriangles_);
    if (!tree) return {};
    // What deforms vertices knows nothing of another origin.
    return Cut{std::move(*tree), isDeformable(drawable) ? Vec3(Vec3::Zero()) : storageOriginOf(drawable)};
  }

  const std::optional<Cut>& sharedCut(const osg::Drawable& drawable) {
    const auto [entry, isNew] = sharedCuts_.try_emplace(&drawable);
    if (isNew) entry->second = cutOf(drawable);
    return entry->second;
  }

  Status addParts(const Cut& cut, bool isShared, const Place& place) {
    struct Open {
      std::uint32_t parts, left;
    };
    std::vector<Open> open;
    std::uint32_t part = 0;
    for (const std::uint32_t below : cut.tree.shape) {
      if (below > 1) {
        builder_.openNode();
        open.push_back({below, below});
        continue;
      }
      const osg::Geometry& geometry = *cut.tree.parts[part];
      if (Status status = addLeaf(geometry, place, {isShared, &cut.origin, part}); !status) return status;
      if (!isShared) writer_.forget(geometry);
      ++part;
      std::uint32_t done = 1;
      while (!open.empty() && (open.back().left -= done) == 0) {
        done = open.back().parts;
        open.pop_back();
        builder_.closeNode();
      }
    }
    return Done{};
  }

  Status addLeaf(const osg::Drawable& drawable, const Place& place, const Piece& piece) {
    const auto& [parent, drawableIndex, transform, inherited, path, motionPlace] = place;
    static const Vec3 kOwnOrigin = Vec3::Zero();
    const auto written = writer_.writeDrawable(drawable, isDeformable(drawable) ? &kOwnOrigin : piece.origin);
    if (!written)
      return nodeError(path, "drawable " + std::to_string(drawableIndex) + " " + written.error().what);
    const WrittenDrawable& geometry = **written;
    if (geometry.isEmpty) {
      warn("drawables without any vertex are left out");
      return Done{};
    }
    SceneLeaf leaf;
    leaf.drawable = geometry.asset;
    leaf.triangles = geometry.triangles;
    leaf.pathNode = path;
    leaf.source = sourceOf(parent, drawableIndex);
    leaf.graphLeaf = scene_.graphLeafCount;
    leaf.part = piece.part;
    if (maxTriangles_ > 0 && leaf.triangles > maxTriangles_) {
      warn("drawables above the limit of triangles stay whole unless they are plain triangle meshes");
    }
    const auto state = writer_.writeState(writer_.merged(inherited, drawable.getStateSet()));
    if (!state) return state.error();
    leaf.state = *state;
    leaf.meanRgba = meanRgba(geometry.meanColor, writer_.meanColorOf(*state));

    // Shared drawables keep theirs; the points of all others would double the memory of the import.
    std::vector<Vec3> points = piece.isShared ? geometry.points : writer_.takePoints(drawable);
    const auto* billboard = dynamic_cast<const osg::Billboard*>(&parent);
    if (billboard) {
      leaf.billboard = static_cast<std::uint32_t>(scene_.billboards.size());
      scene_.billboards.push_back(billboardOf(*billboard, drawableIndex));
      points = reachOf(points, scene_.billboards.back());
    }
    Vec3 reach = Vec3::Zero(), storageError = geometry.storageError;
    if (billboard) storageError.setConstant(storageError.norm());  // it may turn to any axis
    const auto source = graph_.gltfSources.find(&parent);
    notes_.addLeaf({.graphLeaf = leaf.graphLeaf,
                    .part = leaf.part,
                    .gltfNode = source == graph_.gltfSources.end() ? -1 : source->second.node,
                    .origin = geometry.origin,
                    .storageError = storageError},
                   drawable, points, motionPlace);
    for (Vec3& p : points) {
      reach = reach.cwiseMax(p.cwiseAbs());
      p = (transform.matrix * p.homogeneous()).head<3>();
      if (!p.allFinite()) return nodeError(path, "places a vertex beyond the range of numbers");
    }
    leaf.localToWorld = transform.matrix;
    if (!billboard) {
      leaf.localToWorld.col(3) += transform.matrix.leftCols<3>() * geometry.origin;
    } else if (!geometry.origin.isZero()) {
      return nodeError(path, "is a billboard whose drawable lies far from its origin");
    }
    // Bounds hold the vertices of the file and those that the tiles are sent.
    const Bounds bounds = boundsOf(points, transform.errorAt(reach) + transform.spread(storageError));
    builder_.addLeaf(bounds);
    if (notes_.mayHide() && !motionPlace.hidden) shown_.addLeaf(bounds);
    scene_.leaves.push_back(std::move(leaf));
    return Done{};
  }

  static Billboard billboardOf(const osg::Billboard& node, std::uint32_t drawableIndex) {
    Billboard billboard;
    switch (node.getMode()) {
      case osg::Billboard::POINT_ROT_EYE:
        billboard.mode = Billboard::Mode::PointRotEye;
        break;
      case osg::Billboard::POINT_ROT_WORLD:
        billboard.mode = Billboard::Mode::PointRotWorld;
        break;
      default:
        billboard.mode = Billboard::Mode::AxialRot;
        break;
    }
    billboard.axis = toVec3(node.getAxis());
    billboard.normal = toVec3(node.getNormal());
    billboard.position = toVec3(node.getPosition(drawableIndex));
    return billboard;
  }

  /// The corners of a cube that holds every turn of the points about the billboard's position.
  static std::vector<Vec3> reachOf(const std::vector<Vec3>& points, const Billboard& billboard) {
    double radius = 0;
    for (const Vec3& p : points)
      radius = std::max(radius, p.norm());
    Aabb cube;
    cube.extend(billboard.position);
    cube.inflate(Vec3::Constant(radius * (1 + 1e-12)));
    const std::array<Vec3, 8> corners = Obb::fromAabb(cube).corners();
    return {corners.begin(), corners.end()};
  }

  LeafSource sourceOf(const osg::Node& parent, std::uint32_t drawableIndex) const {
    LeafSource source;
    if (const auto known = graph_.gltfSources.find(&parent); known != graph_.gltfSources.end()) {
      source.gltfNode = static_cast<std::uint32_t>(known->second.node);
      source.gltfPrimitive = static_cast<std::uint32_t>(known->second.primitives.at(drawableIndex));
    } else if (!scene_.isGltf) {
      source.osgDrawable = drawableIndex;
    }
    return source;
  }

  [[nodiscard]] Error nodeError(std::uint32_t path, const std::string& what) const {
    return inputError(scene_.source, "node \"" + scene_.pathOfNode(path) + "\" " + what,
                      "mend or remove it in the scene file");
  }

  const ImportedGraph& graph_;
  Scene& scene_;
  const ExtractOptions& options_;
  std::uint64_t nodesDone_ = 0;
  const std::uint64_t maxTriangles_;  ///< of a leaf; 0: any number
  AssetWriter writer_;
  MotionNotes notes_;
  ObjectHierarchyBuilder builder_;
  ObjectHierarchyBuilder shown_;  ///< of what is shown as loaded alone; for its size
  std::vector<Visit> visits_;
  std::unordered_map<const osg::Drawable*, std::optional<Cut>> sharedCuts_;
  std::set<std::string> warned_;
};

}  // namespace

Result<Scene> extractScene(ImportedGraph graph, const ExtractOptions& options) {
  Scene scene;
  scene.source = options.source;
  scene.isGltf = options.isGltf;
  scene.warnings = graph.warnings;
  if (options.keeper) scene.assets = AssetTable(options.keeper);
  if (Status status = Extractor(graph, scene, options).run(); !status) return status.error();
  if (scene.leaves.empty()) {
    return inputError(options.source, "has nothing to draw",
                      "is it the right file, and does it hold meshes?");
  }
  return scene;
}

}  // namespace tessera

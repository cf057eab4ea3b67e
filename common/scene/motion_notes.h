#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <unordered_set>
#include <vector>

#include <osg/Drawable>
#include <osg/Group>
#include <osg/ref_ptr>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"
#include "common/scene/motion/motion.h"

namespace tessera {

/// Whether the node shows some of its children only, and which ones may change: osg::Switch, osg::LOD,
/// osg::Sequence. Paged levels of detail are not among them: what is not loaded cannot be chosen.
[[nodiscard]] bool choosesChildren(const osg::Node& node);

/// Follows the extraction of a graph, which visits nodes in depth-first pre-order, and notes what may move:
/// of OpenSceneGraph's own formats the skeleton (nodes that choose or have update callbacks, and all above
/// them) with the leaves below it; of glTF the leaves of animated nodes and deformed meshes.
class MotionNotes {
 public:
  /// `graph` must outlive it.
  explicit MotionNotes(const ImportedGraph& graph);

  /// Where the extraction is.
  struct Place {
    osg::Group* skeleton = nullptr;  ///< the nearest node of it; null: none
    Mat4 sinceSkeleton = Mat4::Identity();
    bool moves = false;   ///< a callback above moves it
    bool hidden = false;  ///< not shown as loaded
    std::uint32_t unit = motion::kNone;
  };

  /// Enters a node: `parent` is the place of the node above, which is `above` (null: none), of which it is
  /// child `childIndex`; `local` its own transform, or null.
  [[nodiscard]] Place enter(const osg::Node& node, const Mat4* local, const Place& parent,
                            const osg::Node* above, std::uint32_t childIndex, std::uint32_t graphLeafCount);
  /// Everything below the node was visited.
  void leave(const Place& place, bool isParentHidden, std::uint32_t graphLeafCount);

  struct NewLeaf {
    std::uint32_t graphLeaf = 0, part = 0;
    int gltfNode = -1;
    Vec3 origin = Vec3::Zero();        ///< the stored vertices are relative to it
    Vec3 storageError = Vec3::Zero();  ///< of each of them
  };
  /// `points`: the drawable's, or what holds every turn of a billboard; local coordinates.
  void addLeaf(const NewLeaf& leaf, const osg::Drawable& drawable, const std::vector<Vec3>& points,
               const Place& place);

  /// Some node chooses its children, so that some leaves may be hidden.
  [[nodiscard]] bool mayHide() const { return mayHide_; }

  /// What moves; empty where nothing does. To be called once.
  [[nodiscard]] Result<motion::Motion> finish();
  [[nodiscard]] const std::set<std::string>& warnings() const { return warnings_; }

 private:
  void keepWhatMatters(const osg::Node& root);
  [[nodiscard]] bool hasCallback(const osg::Node& node);
  [[nodiscard]] osg::ref_ptr<osg::Group> copyOf(const osg::Node& node, const Mat4* local);
  [[nodiscard]] std::uint32_t deformationOf(std::uint32_t node, const osg::Drawable& drawable);

  const ImportedGraph& graph_;
  motion::Motion motion_;
  std::unordered_set<const osg::Node*> kept_;
  bool mayHide_ = false;
  std::vector<bool> movesInGltf_;  ///< by node of the motion
  osg::ref_ptr<osg::Group> skeleton_;
  std::vector<const osg::Node*> leafNodes_, unitNodes_;  ///< of the skeleton; of motion_'s leaves and units
  std::set<std::string> warnings_;
};

/// Whether a drawable carries joints or morph targets (deform_arrays.h).
[[nodiscard]] bool isDeformable(const osg::Drawable& drawable);

}  // namespace tessera

#include "common/scene/motion_notes.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include <osg/Array>
#include <osg/Geometry>
#include <osg/LOD>
#include <osg/MatrixTransform>
#include <osg/PagedLOD>
#include <osg/Sequence>
#include <osg/Switch>
#include <osgDB/Registry>

#include "common/hierarchy/object_hierarchy.h"
#include "common/scene/deform_arrays.h"
#include "common/scene/osgb_codec.h"

namespace tessera {

namespace {

using motion::kNone;

osg::Matrixd toOsg(const Mat4& m) {
  osg::Matrixd out;
  Eigen::Map<Mat4>(out.ptr()) = m;  // row vectors by row are column vectors by column
  return out;
}

/// As OpenSceneGraph shows the graph to somebody without a place: the finest level of detail.
bool isShownAsLoaded(const osg::Node& chooser, std::uint32_t child) {
  if (const auto* choice = dynamic_cast<const osg::Switch*>(&chooser)) return choice->getValue(child);
  if (const auto* sequence = dynamic_cast<const osg::Sequence*>(&chooser))
    return static_cast<int>(child) == std::max(sequence->getValue(), 0);
  const auto* lod = dynamic_cast<const osg::LOD*>(&chooser);
  if (!lod) return true;
  float range = 0;
  if (lod->getRangeMode() == osg::LOD::PIXEL_SIZE_ON_SCREEN) {
    for (const auto& [least, most] : lod->getRangeList())
      range = std::max(range, least);
  }
  return child < lod->getRangeList().size() && lod->getMinRange(child) <= range &&
         range < lod->getMaxRange(child);
}

/// The children come one by one, in order, as the extraction enters them.
void attach(osg::Group& to, osg::Node& child, const osg::Node& original, std::uint32_t index) {
  if (auto* choice = dynamic_cast<osg::Switch*>(&to)) {
    choice->addChild(&child, static_cast<const osg::Switch&>(original).getValue(index));
  } else if (auto* lod = dynamic_cast<osg::LOD*>(&to)) {
    const auto& from = static_cast<const osg::LOD&>(original);
    const bool hasRange = index < from.getRangeList().size();
    lod->addChild(&child, hasRange ? from.getMinRange(index) : 0, hasRange ? from.getMaxRange(index) : 0);
  } else if (auto* sequence = dynamic_cast<osg::Sequence*>(&to)) {
    sequence->addChild(&child, static_cast<const osg::Sequence&>(original).getTime(index));
  } else {
    to.addChild(&child);
  }
}

osg::ref_ptr<osg::Group> chooserLike(const osg::Node& node) {
  if (const auto* choice = dynamic_cast<const osg::Switch*>(&node)) {
    osg::ref_ptr<osg::Switch> copy = new osg::Switch;
    copy->setNewChildDefaultValue(choice->getNewChildDefaultValue());
    return copy;
  }
  if (const auto* lod = dynamic_cast<const osg::LOD*>(&node)) {
    osg::ref_ptr<osg::LOD> copy = new osg::LOD;
    // Without geometry it has no bounding sphere that would tell.
    copy->setCenter(lod->getCenter());
    copy->setRadius(lod->getRadius());
    copy->setCenterMode(osg::LOD::USER_DEFINED_CENTER);
    copy->setRangeMode(lod->getRangeMode());
    return copy;
  }
  const auto& from = static_cast<const osg::Sequence&>(node);
  osg::ref_ptr<osg::Sequence> copy = new osg::Sequence;
  osg::Sequence::LoopMode mode = osg::Sequence::LOOP;
  int begin = 0, end = -1, repeats = -1;
  float speed = 1;
  from.getInterval(mode, begin, end);
  from.getDuration(speed, repeats);
  copy->setDefaultTime(from.getDefaultTime());
  copy->setLastFrameTime(from.getLastFrameTime());
  copy->setInterval(mode, begin, end);
  copy->setDuration(speed, repeats);
  copy->setMode(from.getMode());
  return copy;
}

template <class Array>
const Array* attributes(const osg::Geometry& mesh, unsigned int index) {
  return dynamic_cast<const Array*>(mesh.getVertexAttribArray(index));
}

/// For each joint the box of the vertices that follow it.
std::vector<Aabb> jointBoxesOf(const osg::Geometry& mesh, std::size_t jointCount) {
  std::vector<Aabb> boxes(jointCount);
  const auto* vertices = dynamic_cast<const osg::Vec3Array*>(mesh.getVertexArray());
  for (unsigned int set = 0; vertices && set < kMaxJointSets; ++set) {
    const auto* joints = attributes<osg::Vec4usArray>(mesh, jointArray(set));
    const auto* weights = attributes<osg::Vec4Array>(mesh, weightArray(set));
    if (!joints || !weights) break;
    for (std::size_t v = 0; v < std::min(joints->size(), vertices->size()); ++v) {
      for (unsigned int k = 0; k < 4; ++k) {
        const std::size_t joint = (*joints)[v][k];
        const osg::Vec3& p = (*vertices)[v];
        if ((*weights)[v][k] > 0 && joint < jointCount) boxes[joint].extend(Vec3(p.x(), p.y(), p.z()));
      }
    }
  }
  return boxes;
}

std::vector<Aabb> targetBoxesOf(const osg::Geometry& mesh) {
  std::vector<Aabb> boxes;
  while (const auto* shifts =
             attributes<osg::Vec3Array>(mesh, displacementArray(static_cast<unsigned int>(boxes.size())))) {
    Aabb& box = boxes.emplace_back();
    for (const osg::Vec3& d : *shifts)
      box.extend(Vec3(d.x(), d.y(), d.z()));
  }
  return boxes;
}

}  // namespace

bool choosesChildren(const osg::Node& node) {
  if (dynamic_cast<const osg::PagedLOD*>(&node)) return false;
  return dynamic_cast<const osg::Switch*>(&node) || dynamic_cast<const osg::LOD*>(&node) ||
         dynamic_cast<const osg::Sequence*>(&node);
}

bool isDeformable(const osg::Drawable& drawable) {
  const osg::Geometry* mesh = drawable.asGeometry();
  return mesh && (attributes<osg::Vec4usArray>(*mesh, jointArray(0)) ||
                  attributes<osg::Vec3Array>(*mesh, displacementArray(0)));
}

MotionNotes::MotionNotes(const ImportedGraph& graph) : graph_(graph) {
  if (!graph.gltfSources.empty()) {
    motion_.nodes = graph.motion.nodes;
    motion_.channels = graph.motion.channels;
    motion_.skins = graph.motion.skins;
    movesInGltf_.assign(motion_.nodes.size(), false);
    for (const motion::Channel& channel : motion_.channels) {
      if (channel.path != motion::Path::Weights) movesInGltf_[channel.node] = true;
    }
    for (std::size_t i = 0; i < motion_.nodes.size(); ++i) {
      const std::uint32_t parent = motion_.nodes[i].parent;
      if (parent != kNone && movesInGltf_[parent]) movesInGltf_[i] = true;
    }
  } else if (graph.root) {
    keepWhatMatters(*graph.root);
  }
}

/// Each node once, however many parents share it, and without recursion.
void MotionNotes::keepWhatMatters(const osg::Node& root) {
  std::unordered_set<const osg::Node*> seen;
  std::vector<std::pair<const osg::Node*, unsigned int>> open = {{&root, 0}};
  seen.insert(&root);
  while (!open.empty()) {
    auto& [node, next] = open.back();
    const osg::Group* group = node->asGroup();
    if (group && next < group->getNumChildren()) {
      const osg::Node* child = group->getChild(next++);
      if (seen.insert(child).second) open.emplace_back(child, 0);
      continue;
    }
    mayHide_ = mayHide_ || choosesChildren(*node);
    bool isKept = choosesChildren(*node) || hasCallback(*node);
    for (unsigned int i = 0; group && !isKept && i < group->getNumChildren(); ++i)
      isKept = kept_.contains(group->getChild(i));
    if (isKept && group) kept_.insert(node);
    open.pop_back();
  }
}

bool MotionNotes::hasCallback(const osg::Node& node) {
  if (!node.asGroup()) return false;
  bool hasAny = false;
  for (const osg::Callback* callback = node.getUpdateCallback(); callback;
       callback = callback->getNestedCallback()) {
    const std::string name = std::string(callback->libraryName()) + "::" + callback->className();
    osgDB::ObjectWrapper* wrapper = osgDB::Registry::instance()->getObjectWrapperManager()->findWrapper(name);
    if (!wrapper) {
      warnings_.insert("update callbacks of the kind " + name +
                       " are not run: OpenSceneGraph cannot write them");
      return false;
    }
    hasAny = true;
  }
  return hasAny;
}

osg::ref_ptr<osg::Group> MotionNotes::copyOf(const osg::Node& node, const Mat4* local) {
  osg::ref_ptr<osg::Group> copy;
  const bool hasOwnCallback = hasCallback(node);
  if (choosesChildren(node)) {
    copy = chooserLike(node);
    if (hasOwnCallback) copy->setUpdateCallback(const_cast<osg::Callback*>(node.getUpdateCallback()));
  } else if (hasOwnCallback) {
    copy = static_cast<osg::Group*>(node.clone(osg::CopyOp::SHALLOW_COPY));
    copy->removeChildren(0, copy->getNumChildren());
    copy->setStateSet(nullptr);
    copy->setUserDataContainer(nullptr);
    copy->setEventCallback(nullptr);
    copy->setCullCallback(nullptr);
  } else if (local) {
    copy = new osg::MatrixTransform(toOsg(*local));
  } else {
    copy = new osg::Group;
  }
  copy->setName(node.getName());
  return copy;
}

MotionNotes::Place MotionNotes::enter(const osg::Node& node, const Mat4* local, const Place& parent,
                                      const osg::Node* above, std::uint32_t childIndex,
                                      std::uint32_t graphLeafCount) {
  Place place = parent;
  place.unit = kNone;
  const bool isKept = kept_.contains(&node);
  const bool isChoice = above && kept_.contains(above) && choosesChildren(*above);
  if (!isKept && !isChoice) {
    if (local) place.sinceSkeleton = place.sinceSkeleton * *local;
    return place;
  }
  // Everything above is kept, so that nothing has gathered since the skeleton.
  osg::ref_ptr<osg::Group> copy = new osg::Group;
  if (isKept) copy = copyOf(node, local);
  if (parent.skeleton) {
    attach(*parent.skeleton, *copy, *above, childIndex);
  } else {
    skeleton_ = copy;
  }
  place.skeleton = copy;
  place.sinceSkeleton = !isKept && local ? *local : Mat4::Identity();
  place.moves = parent.moves || (isKept && hasCallback(node));
  if (isChoice) {
    place.unit = static_cast<std::uint32_t>(motion_.units.size());
    place.hidden = parent.hidden || !isShownAsLoaded(*above, childIndex);
    motion_.units.push_back({.node = 0, .firstGraphLeaf = graphLeafCount, .lastGraphLeaf = graphLeafCount});
    unitNodes_.push_back(copy);
  }
  return place;
}

void MotionNotes::leave(const Place& place, bool isParentHidden, std::uint32_t graphLeafCount) {
  if (place.unit == kNone) return;
  motion::Unit& unit = motion_.units[place.unit];
  unit.lastGraphLeaf = graphLeafCount;
  if (place.hidden && !isParentHidden)
    appendRange(motion_.hiddenAsLoaded, {unit.firstGraphLeaf, unit.lastGraphLeaf});
}

std::uint32_t MotionNotes::deformationOf(std::uint32_t node, const osg::Drawable& drawable) {
  const osg::Geometry* mesh = drawable.asGeometry();
  if (!mesh || !isDeformable(drawable)) return kNone;
  motion::Deformation deformation;
  const std::uint32_t skin = node < graph_.motionSkins.size() ? graph_.motionSkins[node] : kNone;
  if (skin != kNone && attributes<osg::Vec4usArray>(*mesh, jointArray(0))) {
    deformation.skin = skin;
    deformation.jointBoxes = jointBoxesOf(*mesh, motion_.skins[skin].joints.size());
  }
  deformation.targetBoxes = targetBoxesOf(*mesh);
  if (deformation.targetBoxes.size() > motion_.nodes[node].weights.size()) deformation.targetBoxes.clear();
  if (deformation.skin == kNone && deformation.targetBoxes.empty()) return kNone;
  motion_.deformations.push_back(std::move(deformation));
  return static_cast<std::uint32_t>(motion_.deformations.size() - 1);
}

void MotionNotes::addLeaf(const NewLeaf& made, const osg::Drawable& drawable, const std::vector<Vec3>& points,
                          const Place& place) {
  motion::Leaf leaf;
  const osg::Node* skeletonNode = nullptr;
  if (made.gltfNode >= 0) {
    const auto node = static_cast<std::size_t>(made.gltfNode);
    if (node >= graph_.motionNodes.size() || graph_.motionNodes[node] == kNone) return;
    leaf.node = graph_.motionNodes[node];
    leaf.deformation = deformationOf(leaf.node, drawable);
    if (leaf.deformation == kNone && !movesInGltf_[leaf.node]) return;
  } else {
    if (!place.moves) return;
    skeletonNode = place.skeleton;
    leaf.nodeToLeaf = place.sinceSkeleton;
  }
  leaf.graphLeaf = made.graphLeaf;
  leaf.part = made.part;
  leaf.nodeToLeaf.col(3) += leaf.nodeToLeaf.leftCols<3>() * made.origin;
  leaf.nodeToLeaf(3, 3) = 1;
  // The stored vertices are floats about the origin.
  std::vector<Vec3> stored = points;
  Vec3 reach = Vec3::Zero();
  for (Vec3& p : stored) {
    p -= made.origin;
    reach = reach.cwiseMax(p.cwiseAbs());
  }
  leaf.bounds = boundsOf(stored, made.storageError + 0x1p-23 * reach + Vec3::Constant(0x1p-149));
  leafNodes_.push_back(skeletonNode);
  motion_.leaves.push_back(std::move(leaf));
}

Result<motion::Motion> MotionNotes::finish() {
  if (motion_.empty() || !skeleton_) {
    if (motion_.empty()) return motion::Motion();
    return std::move(motion_);
  }
  std::unordered_map<const osg::Node*, std::uint32_t> numbers;
  std::vector<const osg::Node*> open = {skeleton_.get()};
  while (!open.empty()) {
    const osg::Node* node = open.back();
    open.pop_back();
    numbers.emplace(node, static_cast<std::uint32_t>(numbers.size()));
    const osg::Group* group = node->asGroup();
    for (unsigned int i = group->getNumChildren(); i-- > 0;)
      open.push_back(group->getChild(i));
  }
  for (std::size_t i = 0; i < leafNodes_.size(); ++i)
    motion_.leaves[i].node = numbers.at(leafNodes_[i]);
  for (std::size_t i = 0; i < unitNodes_.size(); ++i)
    motion_.units[i].node = numbers.at(unitNodes_[i]);
  Result<std::string> bytes = OsgbCodec().write(*skeleton_);
  if (!bytes) return bytes.error();
  motion_.skeleton = std::move(*bytes);
  return std::move(motion_);
}

}  // namespace tessera

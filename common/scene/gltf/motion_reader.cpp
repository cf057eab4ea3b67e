#include "common/scene/gltf/motion_reader.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "common/scene/motion/motion.h"

namespace tessera::gltf {

namespace {

using motion::Channel;
using motion::Interpolation;
using motion::Motion;
using motion::Path;

bool isIndexOf(int index, std::size_t count) {
  return index >= 0 && static_cast<std::size_t>(index) < count;
}

template <class T>
const T& at(const std::vector<T>& items, int index) {
  return items[static_cast<std::size_t>(index)];
}

std::size_t targetCount(const tinygltf::Model& model, const tinygltf::Node& node) {
  if (!isIndexOf(node.mesh, model.meshes.size())) return 0;
  std::size_t count = 0;
  for (const tinygltf::Primitive& primitive : at(model.meshes, node.mesh).primitives)
    count = std::max(count, primitive.targets.size());
  return count;
}

/// The node's own weights, else its mesh's, else zeros.
std::vector<float> weightsOf(const tinygltf::Model& model, const tinygltf::Node& node) {
  std::vector<float> weights(targetCount(model, node), 0);
  if (weights.empty()) return weights;
  const std::vector<double>& given =
      node.weights.empty() ? at(model.meshes, node.mesh).weights : node.weights;
  for (std::size_t i = 0; i < std::min(given.size(), weights.size()); ++i) {
    const auto weight = static_cast<float>(given[i]);
    if (std::isfinite(weight)) weights[i] = weight;
  }
  return weights;
}

motion::Node nodeOf(const tinygltf::Model& model, const tinygltf::Node& source) {
  motion::Node node;
  node.weights = weightsOf(model, source);
  if (!source.matrix.empty()) {
    node.hasMatrix = true;
    for (Eigen::Index i = 0; i < 16; ++i)
      node.matrix(i % 4, i / 4) = i % 4 == 3 ? (i == 15 ? 1 : 0) : source.matrix[static_cast<std::size_t>(i)];
    return node;
  }
  if (!source.translation.empty())
    node.trs.translation = {source.translation[0], source.translation[1], source.translation[2]};
  if (!source.rotation.empty()) std::copy_n(source.rotation.begin(), 4, node.trs.rotation.begin());
  if (!source.scale.empty()) node.trs.scale = {source.scale[0], source.scale[1], source.scale[2]};
  return node;
}

class MotionReader {
 public:
  MotionReader(const Document& document, AccessorReader& accessors, Warnings& warnings, ImportedGraph& graph)
      : model_(document.model), accessors_(accessors), warnings_(warnings), graph_(graph) {}

  void read(const std::vector<int>& roots) {
    addNodes(roots);
    for (std::size_t i = 0; i < model_.animations.size(); ++i)
      readAnimation(model_.animations[i], "animation " + std::to_string(i));
    readSkins();
  }

 private:
  Motion& motion() { return graph_.motion; }

  void addNodes(const std::vector<int>& roots) {
    graph_.motionNodes.assign(model_.nodes.size(), motion::kNone);
    std::vector<std::pair<int, std::uint32_t>> open;
    for (const int root : roots)
      open.emplace_back(root, motion::kNone);
    while (!open.empty()) {
      const auto [index, parent] = open.back();
      open.pop_back();
      const tinygltf::Node& source = at(model_.nodes, index);
      const auto number = static_cast<std::uint32_t>(motion().nodes.size());
      graph_.motionNodes[static_cast<std::size_t>(index)] = number;
      motion().nodes.push_back(nodeOf(model_, source));
      motion().nodes.back().parent = parent;
      for (const int child : source.children)
        open.emplace_back(child, number);
    }
  }

  void readAnimation(const tinygltf::Animation& animation, const std::string& name) {
    const std::size_t first = motion().channels.size();
    float period = 0;
    for (std::size_t i = 0; i < animation.channels.size(); ++i) {
      Result<Channel> channel = readChannel(animation, animation.channels[i]);
      if (!channel) {
        if (!channel.error().what.empty()) {
          warnings_.add("animation", name + " channel " + std::to_string(i) + " " + channel.error().what +
                                         "; it is left out");
        }
        continue;
      }
      period = std::max(period, channel->timesS.back());
      if (driven_.emplace(channel->node, channel->path).second) {
        motion().channels.push_back(std::move(*channel));
      } else {
        warnings_.add("animations at once", name + " drives what another one drives, which is played");
      }
    }
    for (std::size_t i = first; i < motion().channels.size(); ++i)
      motion().channels[i].periodS = period;
  }

  static Error fault(std::string what) { return inputError({}, std::move(what)); }

  /// An error without words is of what nobody misses: a target outside of the scene, or of an extension.
  Result<Channel> readChannel(const tinygltf::Animation& animation,
                              const tinygltf::AnimationChannel& source) {
    if (source.target_node < 0) return fault({});
    if (!isIndexOf(source.target_node, model_.nodes.size()))
      return fault("drives a node that does not exist");
    Channel channel;
    channel.node = at(graph_.motionNodes, source.target_node);
    if (channel.node == motion::kNone) return fault({});
    const motion::Node& node = motion().nodes[channel.node];
    if (source.target_path == "translation") {
      channel.path = Path::Translation;
    } else if (source.target_path == "rotation") {
      channel.path = Path::Rotation;
      channel.width = 4;
    } else if (source.target_path == "scale") {
      channel.path = Path::Scale;
    } else if (source.target_path == "weights") {
      channel.path = Path::Weights;
      channel.width = static_cast<std::uint32_t>(node.weights.size());
      if (channel.width == 0) return fault("drives morph targets that do not exist");
    } else {
      return fault({});
    }
    if (channel.path != Path::Weights && node.hasMatrix) return fault("drives a node that has a matrix");
    if (!isIndexOf(source.sampler, animation.samplers.size()))
      return fault("has a sampler that does not exist");
    const tinygltf::AnimationSampler& sampler = at(animation.samplers, source.sampler);
    if (sampler.interpolation == "STEP") {
      channel.interpolation = Interpolation::Step;
    } else if (sampler.interpolation == "CUBICSPLINE") {
      channel.interpolation = Interpolation::CubicSpline;
    } else if (sampler.interpolation != "LINEAR") {
      return fault("has an interpolation that does not exist");
    }
    if (Status status = readKeys(sampler, channel); !status) return status.error();
    return channel;
  }

  Status readKeys(const tinygltf::AnimationSampler& sampler, Channel& channel) {
    const Result<std::vector<float>> times = floatsOf(sampler.input, Attribute::Time);
    if (!times) return times.error();
    const bool isScalar = channel.path == Path::Weights;
    const Result<std::vector<float>> values =
        floatsOf(sampler.output, isScalar                         ? Attribute::MorphWeight
                                 : channel.path == Path::Rotation ? Attribute::Rotation
                                                                  : Attribute::Displacement);
    if (!values) return values.error();
    const bool isAscending = std::adjacent_find(times->begin(), times->end(),
                                                [](float a, float b) { return !(a < b); }) == times->end();
    if (times->empty() || !isAscending || times->front() < 0)
      return fault("has times that do not ascend from 0");
    const std::size_t perKey = channel.width * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
    if (values->size() != times->size() * perKey)
      return fault("has another number of values than its times ask for");
    channel.timesS = *times;
    channel.values = *values;
    return Done{};
  }

  Result<std::vector<float>> floatsOf(int accessor, Attribute use) {
    const Result<Elements> elements = accessors_.elements(accessor, use);
    if (!elements) return elements.error();
    std::vector<float> values(elements->count * static_cast<std::size_t>(elements->componentCount));
    gatherFloats(*elements, {}, values);
    if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
      return fault("has a number that is not finite");
    return values;
  }

  void readSkins() {
    std::vector<std::uint32_t> skins(model_.skins.size(), motion::kNone);
    for (std::size_t i = 0; i < model_.skins.size(); ++i) {
      Result<motion::Skin> skin = readSkin(model_.skins[i]);
      if (!skin) {
        warnings_.add("skin", "skin " + std::to_string(i) + " " + skin.error().what + "; it is left out");
        continue;
      }
      skins[i] = static_cast<std::uint32_t>(motion().skins.size());
      motion().skins.push_back(std::move(*skin));
    }
    graph_.motionSkins.assign(motion().nodes.size(), motion::kNone);
    for (std::size_t i = 0; i < model_.nodes.size(); ++i) {
      const std::uint32_t node = graph_.motionNodes[i];
      if (node != motion::kNone && isIndexOf(model_.nodes[i].skin, skins.size()))
        graph_.motionSkins[node] = at(skins, model_.nodes[i].skin);
    }
  }

  Result<motion::Skin> readSkin(const tinygltf::Skin& source) {
    constexpr std::size_t kMaxJoints = 4096;  // as a pose may have
    motion::Skin skin;
    if (source.joints.empty() || source.joints.size() > kMaxJoints)
      return fault("has no joints, or more than " + std::to_string(kMaxJoints));
    for (const int joint : source.joints) {
      if (!isIndexOf(joint, graph_.motionNodes.size()) || at(graph_.motionNodes, joint) == motion::kNone)
        return fault("has a joint that is no node of the scene");
      skin.joints.push_back(at(graph_.motionNodes, joint));
    }
    skin.inverseBind.assign(skin.joints.size(), Mat4::Identity());
    if (source.inverseBindMatrices < 0) return skin;
    const Result<std::vector<float>> values = floatsOf(source.inverseBindMatrices, Attribute::Matrix);
    if (!values) return values.error();
    if (values->size() < 16 * skin.joints.size()) return fault("has fewer inverse bind matrices than joints");
    for (std::size_t joint = 0; joint < skin.joints.size(); ++joint) {
      skin.inverseBind[joint] = Eigen::Map<const Eigen::Matrix4f>(values->data() + 16 * joint).cast<double>();
      // The last row is (0, 0, 0, 1) by definition.
      skin.inverseBind[joint].row(3) << 0, 0, 0, 1;
    }
    return skin;
  }

  const tinygltf::Model& model_;
  AccessorReader& accessors_;
  Warnings& warnings_;
  ImportedGraph& graph_;
  std::set<std::pair<std::uint32_t, Path>> driven_;
};

}  // namespace

std::vector<MeshDeforms> meshDeforms(const Document& document) {
  const tinygltf::Model& model = document.model;
  std::vector<MeshDeforms> deforms(model.meshes.size());
  for (const tinygltf::Node& node : model.nodes) {
    if (!isIndexOf(node.mesh, deforms.size())) continue;
    MeshDeforms& mesh = deforms[static_cast<std::size_t>(node.mesh)];
    if (isIndexOf(node.skin, model.skins.size())) mesh.hasSkin = true;
    const std::vector<float> weights = weightsOf(model, node);
    if (std::any_of(weights.begin(), weights.end(), [](float w) { return w != 0; })) mesh.isMorphed = true;
  }
  for (const tinygltf::Animation& animation : model.animations) {
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      if (channel.target_path != "weights" || !isIndexOf(channel.target_node, model.nodes.size())) continue;
      const int mesh = at(model.nodes, channel.target_node).mesh;
      if (isIndexOf(mesh, deforms.size())) deforms[static_cast<std::size_t>(mesh)].isMorphed = true;
    }
  }
  return deforms;
}

void readMotion(const Document& document, AccessorReader& accessors, const std::vector<int>& roots,
                Warnings& warnings, ImportedGraph& graph) {
  const std::vector<MeshDeforms> deforms = meshDeforms(document);
  const bool deformsAny = std::any_of(deforms.begin(), deforms.end(),
                                      [](const MeshDeforms& mesh) { return mesh.hasSkin || mesh.isMorphed; });
  if (document.model.animations.empty() && !deformsAny) return;
  MotionReader(document, accessors, warnings, graph).read(roots);
}

}  // namespace tessera::gltf

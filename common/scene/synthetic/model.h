#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/synthetic/glb_writer.h"
#include "common/scene/synthetic/shapes.h"

namespace tessera::synthetic {

struct GroupId {
  std::uint32_t node = 0;
};
struct FormId {
  std::uint32_t index = 0;
};
using Parts = std::vector<Part>;

/// A scene before tessellation: groups, leaves and what the leaves are made of. Leaves that are alike can
/// share a form and so a mesh.
class Model {
 public:
  explicit Model(std::string name);

  [[nodiscard]] GroupId root() const { return {0}; }
  GroupId group(GroupId parent, const std::string& name, const Placement& placement = {});
  std::uint32_t material(const Material& material);
  FormId form(std::uint32_t material, Parts parts);
  void leaf(GroupId parent, const std::string& name, FormId form, const Placement& placement = {});
  void leaf(GroupId parent, const std::string& name, std::uint32_t material, Parts parts,
            const Placement& placement = {}) {
    leaf(parent, name, form(material, std::move(parts)), placement);
  }

  [[nodiscard]] std::uint32_t leafCount() const { return leafCount_; }
  [[nodiscard]] std::uint32_t groupCount() const {
    return static_cast<std::uint32_t>(nodes_.size()) - leafCount_;
  }

  /// Splits the largest groups into neighbouring halves until there are `wanted` groups.
  /// False where there already are more, or too few leaves.
  [[nodiscard]] bool splitGroupsTo(std::uint32_t wanted);

  /// Triangles as placed: a shared form counts once for each leaf.
  [[nodiscard]] std::uint64_t triangleCount(double level) const;

  /// The .glb with about `triangles` triangles as placed: the closest that the shapes allow.
  [[nodiscard]] Result<std::string> toGlb(std::uint64_t triangles) const;

 private:
  struct Node {
    std::uint32_t parent = 0;
    std::uint32_t form = GlbWriter::kNone;  ///< none: a group
    std::string name;
    Placement placement;
  };
  struct Form {
    std::uint32_t material = 0;
    std::uint32_t leafCount = 0;
    std::uint32_t firstPart = 0;  ///< number of its first part in the whole model, for the dither
    Parts parts;
  };

  [[nodiscard]] static Detail detailOf(const Form& form, std::size_t part, double level);
  [[nodiscard]] std::uint64_t triangleCount(const Form& form, double level) const;
  [[nodiscard]] std::vector<double> levelsFor(std::uint64_t triangles) const;
  /// Moves `members`, children of `node`, into a new group under it.
  std::uint32_t gather(std::uint32_t node, std::span<const std::uint32_t> members,
                       std::vector<std::vector<std::uint32_t>>& children);
  /// Gathers half of the node's children into a new group, and the others too where `inTwo`.
  void splitGroup(std::uint32_t node, bool inTwo, std::vector<std::vector<std::uint32_t>>& children);

  std::string name_;
  std::vector<Node> nodes_;
  std::vector<Form> forms_;
  std::vector<Material> materials_;
  std::uint32_t leafCount_ = 0;
  std::uint32_t partCount_ = 0;
};

}  // namespace tessera::synthetic

#include "common/scene/synthetic/model.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace tessera::synthetic {
namespace {

/// Beyond any use: about a thousand times the triangles of level 1.
constexpr double kLevelLimit = 64;
constexpr const char* kSection = " section";

}  // namespace

Model::Model(std::string name) : name_(std::move(name)) {
  nodes_.push_back({.name = name_, .placement = {}});
}

GroupId Model::group(GroupId parent, const std::string& name, const Placement& placement) {
  nodes_.push_back({.parent = parent.node, .name = name, .placement = placement});
  return {static_cast<std::uint32_t>(nodes_.size() - 1)};
}

std::uint32_t Model::material(const Material& material) {
  materials_.push_back(material);
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

FormId Model::form(std::uint32_t material, Parts parts) {
  const auto partCount = static_cast<std::uint32_t>(parts.size());
  forms_.push_back(
      {.material = material, .leafCount = 0, .firstPart = partCount_, .parts = std::move(parts)});
  partCount_ += partCount;
  return {static_cast<std::uint32_t>(forms_.size() - 1)};
}

void Model::leaf(GroupId parent, const std::string& name, FormId form, const Placement& placement) {
  nodes_.push_back({.parent = parent.node, .form = form.index, .name = name, .placement = placement});
  ++forms_[form.index].leafCount;
  ++leafCount_;
}

Detail Model::detailOf(const Form& form, std::size_t part, double level) {
  // The golden ratio's multiples spread evenly, however many parts there are.
  const double spread = 0.6180339887498949 * static_cast<double>(form.firstPart + part);
  return {.level = level, .dither = spread - std::floor(spread)};
}

std::uint64_t Model::triangleCount(const Form& form, double level) const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < form.parts.size(); ++i) {
    sum += synthetic::triangleCount(form.parts[i], detailOf(form, i, level));
  }
  return sum * form.leafCount;
}

std::uint64_t Model::triangleCount(double level) const {
  std::uint64_t sum = 0;
  for (const Form& form : forms_)
    sum += triangleCount(form, level);
  return sum;
}

std::vector<double> Model::levelsFor(std::uint64_t triangles) const {
  double low = 0;
  double high = kLevelLimit;
  std::uint64_t sum = triangleCount(low);
  const std::uint64_t near = triangles / 2000;
  for (int i = 0; i < 40 && sum + near < triangles; ++i) {
    const double middle = (low + high) / 2;
    const std::uint64_t count = triangleCount(middle);
    if (count > triangles) {
      high = middle;
    } else {
      low = middle;
      sum = count;
    }
  }
  // Counts jump where many leaves share a form; what is then missing, the first forms make good.
  std::vector<double> levels(forms_.size(), low);
  for (std::size_t i = 0; i < forms_.size() && sum < triangles; ++i) {
    const std::uint64_t more = triangleCount(forms_[i], low * 1.02) - triangleCount(forms_[i], low);
    if (sum + more > triangles) continue;
    levels[i] = low * 1.02;
    sum += more;
  }
  return levels;
}

Result<std::string> Model::toGlb(std::uint64_t triangles) const {
  const std::vector<double> levels = levelsFor(triangles);
  GlbWriter writer(name_);
  for (const Material& m : materials_)
    writer.addMaterial(m);
  std::vector<std::uint32_t> meshes;
  Mesh mesh;
  for (std::size_t f = 0; f < forms_.size(); ++f) {
    const Form& form = forms_[f];
    mesh.positions.clear();
    mesh.normals.clear();
    mesh.indices.clear();
    for (std::size_t i = 0; i < form.parts.size(); ++i) {
      build(form.parts[i], detailOf(form, i, levels[f]), mesh);
    }
    meshes.push_back(writer.addMesh(writer.addGeometry(mesh), form.material));
  }
  // In pre-order, so that a subtree is one stretch of the file.
  std::vector<std::vector<std::uint32_t>> children(nodes_.size());
  for (std::uint32_t i = 1; i < nodes_.size(); ++i)
    children[nodes_[i].parent].push_back(i);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open = {{0, GlbWriter::kNone}};
  while (!open.empty()) {
    const auto [id, parent] = open.back();
    open.pop_back();
    const Node& node = nodes_[id];
    const std::uint32_t written =
        writer.addNode({.parent = parent,
                        .mesh = node.form == GlbWriter::kNone ? GlbWriter::kNone : meshes[node.form],
                        .name = node.name,
                        .placement = node.placement});
    for (auto child = children[id].rbegin(); child != children[id].rend(); ++child) {
      open.emplace_back(*child, written);
    }
  }
  return std::move(writer).finish();
}

std::uint32_t Model::gather(std::uint32_t node, std::span<const std::uint32_t> members,
                            std::vector<std::vector<std::uint32_t>>& children) {
  const auto section = static_cast<std::uint32_t>(nodes_.size());
  const Vec3 origin = nodes_[members.front()].placement.positionM;
  const std::string& name = nodes_[node].name;
  const bool isSection = name.ends_with(kSection);
  nodes_.push_back({.parent = node, .name = isSection ? name : name + kSection, .placement = at(origin)});
  children.emplace_back(members.begin(), members.end());
  for (const std::uint32_t m : members) {
    nodes_[m].parent = section;
    nodes_[m].placement.positionM -= origin;
  }
  children[node].push_back(section);
  return section;
}

void Model::splitGroup(std::uint32_t node, bool inTwo, std::vector<std::vector<std::uint32_t>>& children) {
  std::vector<std::uint32_t> members = std::exchange(children[node], {});
  Vec3 low = nodes_[members.front()].placement.positionM;
  Vec3 high = low;
  for (const std::uint32_t m : members) {
    low = low.cwiseMin(nodes_[m].placement.positionM);
    high = high.cwiseMax(nodes_[m].placement.positionM);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::stable_sort(members.begin(), members.end(), [&](std::uint32_t a, std::uint32_t b) {
    return nodes_[a].placement.positionM[axis] < nodes_[b].placement.positionM[axis];
  });
  const std::span<const std::uint32_t> all = members;
  const std::size_t half = (members.size() + 1) / 2;
  gather(node, all.first(half), children);
  if (inTwo) {
    gather(node, all.subspan(half), children);
  } else {
    children[node].insert(children[node].end(), all.begin() + static_cast<std::ptrdiff_t>(half), all.end());
  }
}

bool Model::splitGroupsTo(std::uint32_t wanted) {
  if (groupCount() > wanted) return false;
  std::vector<std::vector<std::uint32_t>> children(nodes_.size());
  for (std::uint32_t i = 1; i < nodes_.size(); ++i)
    children[nodes_[i].parent].push_back(i);
  // Largest group first; among equals the first.
  using Entry = std::pair<std::size_t, std::uint32_t>;
  const auto later = [](const Entry& a, const Entry& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  };
  std::priority_queue<Entry, std::vector<Entry>, decltype(later)> queue(later);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].form == GlbWriter::kNone) queue.emplace(children[i].size(), i);
  }
  while (groupCount() < wanted) {
    if (queue.empty() || queue.top().first < 3) return false;
    const auto [memberCount, node] = queue.top();
    queue.pop();
    const auto firstNew = static_cast<std::uint32_t>(nodes_.size());
    splitGroup(node, memberCount >= 4 && groupCount() + 2 <= wanted, children);
    queue.emplace(children[node].size(), node);
    for (std::uint32_t i = firstNew; i < nodes_.size(); ++i)
      queue.emplace(children[i].size(), i);
  }
  return true;
}

}  // namespace tessera::synthetic

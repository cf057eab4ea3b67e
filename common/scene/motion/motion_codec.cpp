#include "common/scene/motion/motion_codec.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

namespace tessera::motion {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

constexpr std::string_view kMagic = "TSMOTN01";

class Writer {
 public:
  template <class T>
  void number(T value) {
    static_assert(std::is_arithmetic_v<T>);
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void numbers(const std::vector<T>& values) {
    number(static_cast<std::uint64_t>(values.size()));
    out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  template <class Item, class Write>
  void list(const std::vector<Item>& items, Write write) {
    number(static_cast<std::uint64_t>(items.size()));
    for (const Item& item : items)
      write(item);
  }
  void vec3(const Vec3& v) {
    for (const double value : v)
      number(value);
  }
  void mat4(const Mat4& m) {
    for (Eigen::Index i = 0; i < 12; ++i)
      number(m(i % 3, i / 3));
  }
  void box(const Aabb& box) { vec3(box.min), vec3(box.max); }
  void bounds(const Bounds& bounds) {
    box(bounds.aabb);
    vec3(bounds.obb.center);
    for (const Vec3& axis : bounds.obb.halfAxes)
      vec3(axis);
    vec3(bounds.sphere.center);
    number(bounds.sphere.radius);
  }
  std::string out;
};

/// Reads what Writer writes; after the first failure everything is 0 and empty.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  T number() {
    T value{};
    if (!require(rest_.size() >= sizeof value, "ends too early")) return value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  template <class T>
  T finite() {
    const T value = number<T>();
    require(std::isfinite(value), "has a number that is not finite");
    return value;
  }
  template <class T>
  std::vector<T> numbers() {
    std::vector<T> values(count(sizeof(T)));
    if (values.empty()) return values;
    std::memcpy(values.data(), rest_.data(), values.size() * sizeof(T));
    rest_.remove_prefix(values.size() * sizeof(T));
    if constexpr (std::is_floating_point_v<T>) {
      for (const T value : values)
        require(std::isfinite(value), "has a number that is not finite");
    }
    return values;
  }
  /// `leastBytes` that an item takes bound the number of items by the bytes that are there.
  template <class Read>
  auto list(std::size_t leastBytes, Read read) {
    std::vector<decltype(read())> items;
    const std::size_t items_ = count(leastBytes);
    items.reserve(items_);
    for (std::size_t i = 0; i < items_ && !failure_; ++i)
      items.push_back(read());
    return items;
  }
  std::string text() {
    const std::size_t size = count(1);
    std::string text(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return text;
  }
  Vec3 vec3() {
    const double x = finite<double>(), y = finite<double>(), z = finite<double>();
    return {x, y, z};
  }
  Mat4 mat4() {
    Mat4 m = Mat4::Identity();
    for (Eigen::Index i = 0; i < 12; ++i)
      m(i % 3, i / 3) = finite<double>();
    return m;
  }
  /// Empty boxes are inverted ones of infinities.
  Aabb box() {
    Aabb box;
    for (Vec3* corner : {&box.min, &box.max}) {
      for (double& value : *corner)
        value = number<double>();
    }
    if (box.empty()) return Aabb();
    require(box.min.allFinite() && box.max.allFinite() && (box.min.array() <= box.max.array()).all(),
            "has a box that is none");
    return box;
  }
  Bounds bounds() {
    Bounds bounds;
    bounds.aabb = box();
    bounds.obb.center = vec3();
    for (Vec3& axis : bounds.obb.halfAxes)
      axis = vec3();
    bounds.sphere.center = vec3();
    bounds.sphere.radius = finite<double>();
    require(!bounds.aabb.empty() && bounds.sphere.radius >= 0, "has bounds of nothing");
    return bounds;
  }
  void magic() {
    require(rest_.starts_with(kMagic), "is of another kind or version");
    if (!failure_) rest_.remove_prefix(kMagic.size());
  }
  void end() { require(rest_.empty(), "has bytes left over"); }
  bool require(bool isGood, const char* what) {
    if (!isGood && !failure_) {
      failure_ = inputError("scene motion", what, "build the scene's index again");
      rest_ = {};
    }
    return !failure_;
  }
  [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

 private:
  std::size_t count(std::size_t leastBytes) {
    const auto count = number<std::uint64_t>();
    if (!require(count <= rest_.size() / leastBytes, "ends too early")) return 0;
    return static_cast<std::size_t>(count);
  }

  std::string_view rest_;
  std::optional<Error> failure_;
};

constexpr std::size_t kBoxBytes = 48, kMatrixBytes = 96, kBoundsBytes = kBoxBytes + 8 * (12 + 4);
constexpr std::size_t kNodeBytes = 4 + 1 + 80 + 8, kChannelBytes = 4 + 2 + 4 + 4 + 16, kSkinBytes = 16;
constexpr std::size_t kDeformationBytes = 4 + 16, kLeafBytes = 16 + kMatrixBytes + kBoundsBytes;

void writeNode(Writer& to, const Node& node) {
  to.number(node.parent);
  to.number(static_cast<std::uint8_t>(node.hasMatrix));
  if (node.hasMatrix) {
    to.mat4(node.matrix);
  } else {
    to.vec3(node.trs.translation);
    for (const double value : node.trs.rotation)
      to.number(value);
    to.vec3(node.trs.scale);
  }
  to.numbers(node.weights);
}

Node readNode(Reader& from) {
  Node node;
  node.parent = from.number<std::uint32_t>();
  node.hasMatrix = from.number<std::uint8_t>() != 0;
  if (node.hasMatrix) {
    node.matrix = from.mat4();
  } else {
    node.trs.translation = from.vec3();
    for (double& value : node.trs.rotation)
      value = from.finite<double>();
    node.trs.scale = from.vec3();
  }
  node.weights = from.numbers<float>();
  return node;
}

void writeChannel(Writer& to, const Channel& channel) {
  to.number(channel.node);
  to.number(static_cast<std::uint8_t>(channel.path));
  to.number(static_cast<std::uint8_t>(channel.interpolation));
  to.number(channel.periodS);
  to.number(channel.width);
  to.numbers(channel.timesS);
  to.numbers(channel.values);
}

Channel readChannel(Reader& from) {
  Channel channel;
  channel.node = from.number<std::uint32_t>();
  const auto path = from.number<std::uint8_t>(), interpolation = from.number<std::uint8_t>();
  from.require(path <= 3 && interpolation <= 2, "has a channel of an unknown kind");
  channel.path = static_cast<Path>(path);
  channel.interpolation = static_cast<Interpolation>(interpolation);
  channel.periodS = from.finite<float>();
  channel.width = from.number<std::uint32_t>();
  channel.timesS = from.numbers<float>();
  channel.values = from.numbers<float>();
  const std::uint64_t perKey =
      std::uint64_t{channel.width} * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
  bool isSound = !channel.timesS.empty() && channel.periodS >= 0 && channel.width > 0 &&
                 channel.values.size() % perKey == 0 &&
                 channel.values.size() / perKey == channel.timesS.size();
  if (channel.path == Path::Rotation) isSound = isSound && channel.width == 4;
  if (channel.path == Path::Translation || channel.path == Path::Scale)
    isSound = isSound && channel.width == 3;
  for (std::size_t i = 1; i < channel.timesS.size(); ++i)
    isSound = isSound && channel.timesS[i - 1] < channel.timesS[i];
  from.require(isSound, "has a channel whose keys do not fit together");
  return channel;
}

/// Whether everything refers to something that is there.
bool refersWell(const Motion& motion) {
  bool isSound = true;
  const std::size_t nodes = motion.nodes.size();
  const auto checkNode = [&](std::uint32_t node) { isSound = isSound && node < nodes; };
  for (std::size_t i = 0; i < nodes; ++i)
    isSound = isSound && (motion.nodes[i].parent == kNone || motion.nodes[i].parent < i);
  for (const Channel& channel : motion.channels) {
    checkNode(channel.node);
    if (isSound && channel.path == Path::Weights)
      isSound = motion.nodes[channel.node].weights.size() == channel.width;
    if (isSound && channel.path != Path::Weights) isSound = !motion.nodes[channel.node].hasMatrix;
  }
  for (const Skin& skin : motion.skins) {
    isSound = isSound && skin.joints.size() == skin.inverseBind.size() && !skin.joints.empty();
    for (const std::uint32_t joint : skin.joints)
      checkNode(joint);
  }
  for (const Deformation& deformation : motion.deformations) {
    if (deformation.skin == kNone) continue;
    isSound = isSound && deformation.skin < motion.skins.size() &&
              deformation.jointBoxes.size() == motion.skins[deformation.skin].joints.size();
  }
  for (const Leaf& leaf : motion.leaves) {
    if (motion.skeleton.empty()) checkNode(leaf.node);
    if (leaf.deformation == kNone || !isSound) continue;
    isSound = leaf.deformation < motion.deformations.size() && motion.skeleton.empty();
    if (isSound)
      isSound =
          motion.nodes[leaf.node].weights.size() >= motion.deformations[leaf.deformation].targetBoxes.size();
  }
  for (const Unit& unit : motion.units)
    isSound = isSound && unit.firstGraphLeaf <= unit.lastGraphLeaf && !motion.skeleton.empty();
  return isSound && isCanonical(motion.hiddenAsLoaded, UINT32_MAX);
}

}  // namespace

std::string encodeMotion(const Motion& motion) {
  if (motion.empty()) return {};
  Writer to;
  to.out = kMagic;
  to.list(motion.nodes, [&](const Node& node) { writeNode(to, node); });
  to.list(motion.channels, [&](const Channel& channel) { writeChannel(to, channel); });
  to.list(motion.skins, [&](const Skin& skin) {
    to.numbers(skin.joints);
    to.list(skin.inverseBind, [&](const Mat4& m) { to.mat4(m); });
  });
  to.list(motion.deformations, [&](const Deformation& deformation) {
    to.number(deformation.skin);
    to.list(deformation.jointBoxes, [&](const Aabb& box) { to.box(box); });
    to.list(deformation.targetBoxes, [&](const Aabb& box) { to.box(box); });
  });
  to.list(motion.leaves, [&](const Leaf& leaf) {
    for (const std::uint32_t number : {leaf.graphLeaf, leaf.part, leaf.node, leaf.deformation})
      to.number(number);
    to.mat4(leaf.nodeToLeaf);
    to.bounds(leaf.bounds);
  });
  to.number(static_cast<std::uint64_t>(motion.skeleton.size()));
  to.out += motion.skeleton;
  to.list(motion.units, [&](const Unit& unit) {
    for (const std::uint32_t number : {unit.node, unit.firstGraphLeaf, unit.lastGraphLeaf})
      to.number(number);
  });
  to.list(motion.hiddenAsLoaded, [&](const LeafRange& range) {
    to.number(range.first);
    to.number(range.last);
  });
  to.vec3(motion.shownAsLoaded.center);
  to.number(motion.shownAsLoaded.radius);
  return std::move(to.out);
}

Result<Motion> decodeMotion(std::string_view bytes) {
  Motion motion;
  if (bytes.empty()) return motion;
  Reader from(bytes);
  from.magic();
  motion.nodes = from.list(kNodeBytes, [&] { return readNode(from); });
  motion.channels = from.list(kChannelBytes, [&] { return readChannel(from); });
  motion.skins = from.list(kSkinBytes, [&] {
    Skin skin;
    skin.joints = from.numbers<std::uint32_t>();
    skin.inverseBind = from.list(kMatrixBytes, [&] { return from.mat4(); });
    return skin;
  });
  motion.deformations = from.list(kDeformationBytes, [&] {
    Deformation deformation;
    deformation.skin = from.number<std::uint32_t>();
    deformation.jointBoxes = from.list(kBoxBytes, [&] { return from.box(); });
    deformation.targetBoxes = from.list(kBoxBytes, [&] { return from.box(); });
    return deformation;
  });
  motion.leaves = from.list(kLeafBytes, [&] {
    Leaf leaf;
    for (std::uint32_t* number : {&leaf.graphLeaf, &leaf.part, &leaf.node, &leaf.deformation})
      *number = from.number<std::uint32_t>();
    leaf.nodeToLeaf = from.mat4();
    leaf.bounds = from.bounds();
    return leaf;
  });
  motion.skeleton = from.text();
  motion.units = from.list(12, [&] {
    Unit unit;
    for (std::uint32_t* number : {&unit.node, &unit.firstGraphLeaf, &unit.lastGraphLeaf})
      *number = from.number<std::uint32_t>();
    return unit;
  });
  motion.hiddenAsLoaded = from.list(8, [&] {
    const auto first = from.number<std::uint32_t>(), last = from.number<std::uint32_t>();
    return LeafRange{first, last};
  });
  motion.shownAsLoaded.center = from.vec3();
  motion.shownAsLoaded.radius = from.finite<double>();
  from.end();
  if (!from.failure()) from.require(refersWell(motion), "refers to something that is not there");
  if (from.failure()) return *from.failure();
  return motion;
}

}  // namespace tessera::motion

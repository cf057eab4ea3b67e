#include "proto/pose_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Geometry>

#include "proto/little_endian.h"
#include "proto/protocol_error.h"

namespace tessera::proto {

namespace {

constexpr std::uint8_t kFormBits = 3, kHasJoints = 4, kHasWeights = 8;
/// An id, the flags, and the least that either announces: a count and one weight.
constexpr std::size_t kMinPoseBytes = 1 + 1 + 1 + 4;

void appendVarint(std::uint64_t number, std::vector<std::byte>& out) {
  for (; number >= 0x80U; number >>= 7U)
    out.push_back(static_cast<std::byte>((number & 0x7FU) | 0x80U));
  out.push_back(static_cast<std::byte>(number));
}

template <class U>
void appendFixed(U number, std::vector<std::byte>& out) {
  out.resize(out.size() + sizeof(U));
  storeLittleEndian(number, std::span(out).template last<sizeof(U)>());
}

void appendFloats(std::span<const float> numbers, std::size_t perCount, std::vector<std::byte>& out) {
  appendVarint(numbers.size() / perCount, out);
  for (const float number : numbers)
    appendFixed(std::bit_cast<std::uint32_t>(number), out);
}

std::uint64_t zigzag(std::int64_t number) {
  return (static_cast<std::uint64_t>(number) << 1U) ^ static_cast<std::uint64_t>(number >> 63);
}

std::int64_t unzigzag(std::uint64_t number) {
  return static_cast<std::int64_t>(number >> 1U) ^ -static_cast<std::int64_t>(number & 1U);
}

/// Reads poses one after the other; the first failure stays, and everything after it is 0.
class PoseReader {
 public:
  explicit PoseReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  Result<std::vector<Pose>> read() {
    const std::uint64_t count = varint();
    require(count <= kMaxLeavesPerMessage, ProtocolError::BadCount);
    require(count <= rest_.size() / kMinPoseBytes, ProtocolError::Truncated);
    std::vector<Pose> poses;
    if (!failure_) poses.reserve(count);
    std::uint64_t next = 0;
    for (std::uint64_t i = 0; i < count && !failure_; ++i) {
      const std::uint64_t id = next + varint();
      require(id <= UINT32_MAX, ProtocolError::BadNumber);
      next = id + 1;
      poses.push_back(pose(static_cast<std::uint32_t>(id)));
    }
    require(rest_.empty(), ProtocolError::TrailingBytes);
    if (failure_) return *failure_;
    return poses;
  }

 private:
  Pose pose(std::uint32_t id) {
    Pose pose{.id = id};
    const auto flags = fixed<std::uint8_t>();
    const auto form = static_cast<std::uint8_t>(flags & kFormBits);
    require(form <= static_cast<std::uint8_t>(PoseForm::Steps) && flags < 16, ProtocolError::BadEnum);
    require(flags != 0, ProtocolError::Malformed);
    pose.form = static_cast<PoseForm>(form);
    if (pose.form == PoseForm::Matrix) pose.localToWorld.topRows<3>() = matrix();
    if (pose.form == PoseForm::Steps) pose.steps = steps();
    if (flags & kHasJoints) floats(12, kMaxPoseJoints, pose.joints);
    if (flags & kHasWeights) floats(1, kMaxPoseWeights, pose.weights);
    return pose;
  }

  Eigen::Matrix<double, 3, 4> matrix() {
    Eigen::Matrix<double, 3, 4> m;
    for (Eigen::Index i = 0; i < 12; ++i)
      m(i % 3, i / 3) = std::bit_cast<double>(fixed<std::uint64_t>());
    require(m.allFinite(), ProtocolError::BadNumber);
    return m;
  }

  PoseSteps steps() {
    PoseSteps steps;
    for (std::int8_t& exponent : steps.exponents)
      exponent = static_cast<std::int8_t>(fixed<std::uint8_t>());
    for (std::int64_t& count : steps.counts) {
      count = unzigzag(varint());
      require(count >= -kMaxPoseSteps && count <= kMaxPoseSteps, ProtocolError::BadNumber);
    }
    return steps;
  }

  void floats(std::size_t perCount, std::size_t limit, std::vector<float>& out) {
    const std::uint64_t count = varint();
    require(count > 0 && count <= limit, ProtocolError::BadCount);
    require(count <= rest_.size() / (4 * perCount), ProtocolError::Truncated);
    if (failure_) return;
    out.resize(count * perCount);
    for (float& number : out) {
      number = std::bit_cast<float>(fixed<std::uint32_t>());
      require(std::isfinite(number), ProtocolError::BadNumber);
    }
  }

  std::uint64_t varint() {
    std::uint64_t number = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = fixed<std::uint8_t>();
      number |= std::uint64_t{byte & 0x7FU} << shift;
      if (byte & 0x80U) continue;
      // A padded form, or bits beyond the 64th.
      require((byte != 0 || shift == 0) && (shift < 63 || byte <= 1), ProtocolError::BadNumber);
      return failure_ ? 0 : number;
    }
    require(false, ProtocolError::BadNumber);
    return 0;
  }

  template <class U>
  U fixed() {
    if (!require(rest_.size() >= sizeof(U), ProtocolError::Truncated)) return 0;
    const U number = loadLittleEndian<U>(rest_.template first<sizeof(U)>());
    rest_ = rest_.subspan(sizeof(U));
    return number;
  }

  bool require(bool isGood, ProtocolError error) {
    if (!isGood && !failure_) failure_ = protocolError(error, "Poses message", "poses");
    return !failure_;
  }

  std::span<const std::byte> rest_;
  std::optional<Error> failure_;
};

/// The largest power of two that is not above `step`, within what an exponent may be.
std::int8_t exponentOf(double step) {
  if (!(step > 0)) return INT8_MIN;
  int exponent = 0;
  static_cast<void>(std::frexp(step, &exponent));
  return static_cast<std::int8_t>(std::clamp(exponent - 1, int{INT8_MIN}, int{INT8_MAX}));
}

/// How far two affine maps put the same point of a box apart at most: at one of its corners, as the distance
/// is convex.
double largestShift(const Mat4& a, const Mat4& b, const Aabb& box) {
  const Mat4 difference = a - b;
  double most = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const Vec3 corner((i & 1 ? box.max : box.min).x(), (i & 2 ? box.max : box.min).y(),
                      (i & 4 ? box.max : box.min).z());
    most = std::max(most, lengthOf((difference * corner.homogeneous()).head<3>()));
  }
  return most;
}

}  // namespace

void encodePoseBytes(std::span<const Pose> poses, std::vector<std::byte>& out) {
  out.clear();
  appendVarint(poses.size(), out);
  std::uint64_t next = 0;
  for (const Pose& pose : poses) {
    appendVarint(pose.id - next, out);
    next = std::uint64_t{pose.id} + 1;
    auto flags = static_cast<std::uint8_t>(pose.form);
    if (!pose.joints.empty()) flags |= kHasJoints;
    if (!pose.weights.empty()) flags |= kHasWeights;
    appendFixed(flags, out);
    if (pose.form == PoseForm::Matrix) {
      for (Eigen::Index i = 0; i < 12; ++i)
        appendFixed(std::bit_cast<std::uint64_t>(pose.localToWorld(i % 3, i / 3)), out);
    }
    if (pose.form == PoseForm::Steps) {
      for (const std::int8_t exponent : pose.steps.exponents)
        appendFixed(static_cast<std::uint8_t>(exponent), out);
      for (const std::int64_t count : pose.steps.counts)
        appendVarint(zigzag(count), out);
    }
    if (!pose.joints.empty()) appendFloats(pose.joints, 12, out);
    if (!pose.weights.empty()) appendFloats(pose.weights, 1, out);
  }
}

Result<std::vector<Pose>> decodePoseBytes(std::span<const std::byte> bytes) {
  return PoseReader(bytes).read();
}

/// A point's three coordinates each err by half a step of the translation and half a step of every column
/// times the point's own coordinate. Each of the four gets a quarter of the bound over sqrt(3), less a little
/// for the roundings of base + count * step, which largestShift sees.
std::optional<PoseSteps> toSteps(const Mat4& base, const Mat4& now, const Aabb& box, double boundM) {
  if (!base.allFinite() || !now.allFinite() || box.empty()) return std::nullopt;
  const Vec3 reach = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs());
  // What is flat is not to lose its direction: normals turn with the columns.
  const double least = 0.05 * reach.maxCoeff();
  const double share = 2 * boundM / (4 * 1.7320509) * 0.99;
  PoseSteps steps;
  for (Eigen::Index column = 0; column < 4; ++column) {
    const double length = column < 3 ? std::max(reach[column], least) : 1;
    steps.exponents[static_cast<std::size_t>(column)] = exponentOf(length > 0 ? share / length : 1);
  }
  for (Eigen::Index i = 0; i < 12; ++i) {
    const int exponent = steps.exponents[static_cast<std::size_t>(i / 3)];
    const double count = std::nearbyint(std::ldexp(now(i % 3, i / 3) - base(i % 3, i / 3), -exponent));
    if (!(std::abs(count) <= static_cast<double>(kMaxPoseSteps))) return std::nullopt;
    steps.counts[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(count);
  }
  const Mat4 reached = fromSteps(base, steps);
  if (!(largestShift(reached, now, box) <= boundM * (1 - 1e-9))) return std::nullopt;
  return steps;
}

Mat4 fromSteps(const Mat4& base, const PoseSteps& steps) {
  Mat4 now = base;
  for (Eigen::Index i = 0; i < 12; ++i) {
    const auto count = static_cast<double>(steps.counts[static_cast<std::size_t>(i)]);
    now(i % 3, i / 3) += std::ldexp(count, steps.exponents[static_cast<std::size_t>(i / 3)]);
  }
  return now;
}

}  // namespace tessera::proto

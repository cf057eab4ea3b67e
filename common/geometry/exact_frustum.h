#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/geometry/frustum.h"

namespace tessera {

/// Does a triangle meet a closed frustum? Decided exactly, from nothing but the frustum's doubles: the judge
/// of cullers. A filter in double answers nearly every question; integers of any length answer the rest.
///
/// The frustum is the set of points p with s.(p - eye) >= 0 for each side s = b x a, a and b being the image
/// rectangle's corners i and i+1 relative to the eye, and where `near` or `far` is given also
///
///     near |n| <= n.(p - eye) <= far |n|      n = +-(c1 - c0) x (c3 - c0), n.(c0 - eye) > 0.
///
/// |n| is irrational in general. It is known between two rationals of relative distance below 2^-200 (equal
/// where |n| is rational), and the one that makes the frustum smaller is taken: a triangle said to meet does
/// meet; one that reaches over near or far by less than 2^-200 of the distance may be said not to.
///
/// Any doubles are allowed. A side whose corners are collinear with the eye is no condition (s = 0). With
/// `near` or `far` given, a rectangle without area or one seen edge-on has no normal: nothing meets it.
/// Nothing meets a frustum with a NaN or with an infinite eye or corner either, and a triangle with such a
/// vertex meets nothing; an infinite `far` is no condition, an infinite `near` is out of reach.
class ExactFrustum {
 public:
  using Triangle = std::array<Vec3, 3>;

  explicit ExactFrustum(const Frustum& frustum);
  ExactFrustum(ExactFrustum&&) noexcept;
  ExactFrustum& operator=(ExactFrustum&&) noexcept;
  ~ExactFrustum();

  /// The filter first, exact arithmetic where that is undecided. World coordinates. Not safe for calls from
  /// several threads at once (it counts).
  [[nodiscard]] bool meets(const Triangle& triangle) const;

  /// The same answer without the filter: some 10 to 100 times slower.
  [[nodiscard]] bool meetsExactly(const Triangle& triangle) const;

  /// How many calls of meets() the filter left undecided.
  [[nodiscard]] std::uint64_t exactDecisions() const { return exactDecisions_; }

 private:
  struct Exact;

  /// n.p - offset >= 0 inside, p relative to the eye. For any p with |p| <= M that has come through the
  /// filter's clipping, |exact value - computed value| <= errorPerUnit.M + errorConstant.
  struct FilterPlane {
    Vec3 n;
    double offset = 0, errorPerUnit = 0, errorConstant = 0;
  };

  void addFilterPlane(const Vec3& a, const Vec3& b, double sign, double distance);
  [[nodiscard]] std::optional<bool> filter(const Triangle& triangle) const;

  Vec3 eye_;
  std::vector<FilterPlane> filterPlanes_;
  bool filterable_ = true;
  std::unique_ptr<Exact> exact_;
  mutable std::uint64_t exactDecisions_ = 0;
};

}  // namespace tessera

#include "common/scene/motion/channel.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace tessera::motion {

namespace {

/// Above this cosine of half the angle between two rotations their arc is a chord, as far as doubles tell.
constexpr double kSameRotation = 1 - 1e-12;

void normalize(std::span<double> q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(length > 0) || !std::isfinite(length)) {
    q[0] = q[1] = q[2] = 0, q[3] = 1;
    return;
  }
  for (double& value : q)
    value /= length;
}

void slerp(std::span<const float> from, std::span<const float> to, double t, std::span<double> out) {
  double cosine = 0;
  for (std::size_t i = 0; i < 4; ++i)
    cosine += static_cast<double>(from[i]) * static_cast<double>(to[i]);
  const double sign = cosine < 0 ? -1 : 1;  // q and -q are the same rotation: the shorter way
  cosine = std::min(std::abs(cosine), 1.0);
  double ofFrom = 1 - t, ofTo = t;
  if (cosine < kSameRotation) {
    const double angle = std::acos(cosine), sine = std::sin(angle);
    ofFrom = std::sin((1 - t) * angle) / sine;
    ofTo = std::sin(t * angle) / sine;
  }
  for (std::size_t i = 0; i < 4; ++i)
    out[i] = ofFrom * static_cast<double>(from[i]) + sign * ofTo * static_cast<double>(to[i]);
}

}  // namespace

void sample(const Channel& channel, double timeS, std::span<double> out) {
  const std::size_t width = channel.width, keys = channel.timesS.size();
  const bool isSpline = channel.interpolation == Interpolation::CubicSpline;
  const bool isRotation = channel.path == Path::Rotation;
  const std::size_t perKey = isSpline ? 3 * width : width;
  // Of splines 0 is the in-tangent, 1 the value, 2 the out-tangent.
  const auto at = [&](std::size_t key, std::size_t part) {
    return std::span(channel.values).subspan(key * perKey + part * width, width);
  };
  const auto valueAt = [&](std::size_t key) { return at(key, isSpline ? 1 : 0); };

  const double period = static_cast<double>(channel.periodS);
  const double time = period > 0 ? std::fmod(timeS, period) : 0;
  const auto after = std::upper_bound(channel.timesS.begin(), channel.timesS.end(), time,
                                      [](double t, float key) { return t < static_cast<double>(key); });
  const auto next = static_cast<std::size_t>(after - channel.timesS.begin());
  if (next == 0 || next == keys || channel.interpolation == Interpolation::Step) {
    std::copy_n(valueAt(next == 0 ? 0 : next - 1).begin(), width, out.begin());
    if (isRotation) normalize(out.first(4));
    return;
  }
  const double start = static_cast<double>(channel.timesS[next - 1]);
  const double length = static_cast<double>(channel.timesS[next]) - start;
  const double t = (time - start) / length;
  if (isRotation && !isSpline) {
    slerp(valueAt(next - 1), valueAt(next), t, out);
  } else if (isSpline) {
    const double t2 = t * t, t3 = t2 * t;
    const double ofFrom = 2 * t3 - 3 * t2 + 1, ofOut = length * (t3 - 2 * t2 + t);
    const double ofTo = 3 * t2 - 2 * t3, ofIn = length * (t3 - t2);
    for (std::size_t i = 0; i < width; ++i) {
      out[i] = ofFrom * static_cast<double>(valueAt(next - 1)[i]) +
               ofOut * static_cast<double>(at(next - 1, 2)[i]) +
               ofTo * static_cast<double>(valueAt(next)[i]) + ofIn * static_cast<double>(at(next, 0)[i]);
    }
  } else {
    for (std::size_t i = 0; i < width; ++i) {
      const double from = static_cast<double>(valueAt(next - 1)[i]);
      out[i] = from + t * (static_cast<double>(valueAt(next)[i]) - from);
    }
  }
  if (isRotation) normalize(out.first(4));
}

Mat4 matrixOf(const Trs& trs) {
  const auto& [x, y, z, w] = trs.rotation;
  Mat4 m = Mat4::Identity();
  m.topLeftCorner<3, 3>() =
      Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix() * trs.scale.asDiagonal();
  m.topRightCorner<3, 1>() = trs.translation;
  return m;
}

}  // namespace tessera::motion

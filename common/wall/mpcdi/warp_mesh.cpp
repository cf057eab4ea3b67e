#include "common/wall/mpcdi/warp_mesh.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace tessera {

namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

/// (u, v) of every sample, in the drawn picture from its upper left corner.
struct Field {
  std::int32_t columns = 0, rows = 0;
  std::vector<float> uv;
  double widthPx = 0, heightPx = 0;  ///< of the drawn picture

  [[nodiscard]] const float* at(std::int32_t column, std::int32_t row) const {
    return uv.data() + 2 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                            static_cast<std::size_t>(column));
  }
  [[nodiscard]] bool isHole(std::int32_t column, std::int32_t row) const {
    return std::isnan(*at(column, row));
  }
};

/// Where samples lie among the cells of one axis of the mesh.
struct Axis {
  Axis(std::int32_t samples, std::int32_t cellCount) : cells(cellCount) {
    for (std::int32_t i = 0; i < samples; ++i) {
      const double position = (i + 0.5) / samples * cells;
      const auto inCell = std::min(static_cast<std::int32_t>(position), cells - 1);
      cell.push_back(inCell);
      within.push_back(position - inCell);
    }
    // The samples of a cell follow each other.
    first.assign(static_cast<std::size_t>(cells) + 1, samples);
    for (std::int32_t i = samples - 1; i >= 0; --i)
      first[static_cast<std::size_t>(cell[static_cast<std::size_t>(i)])] = i;
    for (std::int32_t c = cells - 1; c >= 0; --c)
      first[static_cast<std::size_t>(c)] =
          std::min(first[static_cast<std::size_t>(c)], first[static_cast<std::size_t>(c) + 1]);
  }

  /// The samples of the one or two cells beside a vertex: [begin, end).
  [[nodiscard]] std::int32_t beginBeside(std::int32_t vertex) const {
    return first[static_cast<std::size_t>(std::max(vertex - 1, 0))];
  }
  [[nodiscard]] std::int32_t endBeside(std::int32_t vertex) const {
    return first[static_cast<std::size_t>(std::min(vertex + 1, cells))];
  }

  std::int32_t cells;
  std::vector<std::int32_t> cell, first;
  std::vector<double> within;  ///< 0..1
};

struct Point {
  double u = 0, v = 0;
};

/// Between the four samples around a point of the picture, or beyond the outermost; NaN where one is a hole.
Point interpolated(const Field& field, double s, double t) {
  const auto split = [](double position, std::int32_t count, std::int32_t& low, std::int32_t& high) {
    const double sample = position * count - 0.5;
    low = std::clamp(static_cast<std::int32_t>(std::floor(sample)), 0, std::max(count - 2, 0));
    high = std::min(low + 1, count - 1);
    return high > low ? sample - low : 0.0;
  };
  std::int32_t left = 0, right = 0, top = 0, bottom = 0;
  const double x = split(s, field.columns, left, right), y = split(t, field.rows, top, bottom);
  const float* a = field.at(left, top);
  const float* b = field.at(right, top);
  const float* c = field.at(left, bottom);
  const float* d = field.at(right, bottom);
  const auto mix = [&](int i) {
    return (double{a[i]} * (1 - x) + double{b[i]} * x) * (1 - y) +
           (double{c[i]} * (1 - x) + double{d[i]} * x) * y;
  };
  return {mix(0), mix(1)};
}

/// Whether all samples in the cells beside a vertex are holes.
bool isAmongHoles(const Field& field, const Axis& across, const Axis& down, std::int32_t column,
                  std::int32_t row) {
  for (std::int32_t r = down.beginBeside(row); r < down.endBeside(row); ++r) {
    for (std::int32_t c = across.beginBeside(column); c < across.endBeside(column); ++c) {
      if (!field.isHole(c, r)) return false;
    }
  }
  return true;
}

/// The plane nearest to the samples around a vertex, at the vertex; near ones count more. Beside a ragged
/// hole a cell may hold a sample or two, which say nothing of the slope: then those further away are asked as
/// well.
Point continued(const Field& field, const Axis& across, const Axis& down, std::int32_t column,
                std::int32_t row) {
  if (isAmongHoles(field, across, down, column, row)) return {kNothing, kNothing};
  const double x = static_cast<double>(column) * field.columns / across.cells - 0.5;
  const double y = static_cast<double>(row) * field.rows / down.cells - 0.5;
  double reachX = std::max(4.0, static_cast<double>(field.columns) / across.cells);
  double reachY = std::max(4.0, static_cast<double>(field.rows) / down.cells);
  Eigen::Matrix3d normal;
  Eigen::Matrix<double, 3, 2> right;
  for (int widening = 0;; ++widening, reachX *= 2, reachY *= 2) {
    normal.setZero();
    right.setZero();
    const auto within = [](double at, std::int32_t count) {
      return static_cast<std::int32_t>(std::clamp(at, 0.0, count - 1.0));
    };
    // Of large cells a thousand samples are enough to begin with.
    const auto stepX = static_cast<std::int32_t>(widening == 0 ? std::max(1.0, reachX / 16) : 1.0);
    const auto stepY = static_cast<std::int32_t>(widening == 0 ? std::max(1.0, reachY / 16) : 1.0);
    const std::int32_t lastRow = within(y + reachY, field.rows),
                       lastColumn = within(x + reachX, field.columns);
    for (std::int32_t r = within(std::ceil(y - reachY), field.rows); r <= lastRow; r += stepY) {
      for (std::int32_t c = within(std::ceil(x - reachX), field.columns); c <= lastColumn; c += stepX) {
        if (field.isHole(c, r)) continue;
        const Eigen::Vector3d at(1, (c - x) / reachX, (r - y) / reachY);
        const double weight = 1 / (0.05 + at.tail<2>().squaredNorm());
        normal += weight * at * at.transpose();
        right += weight * at * Eigen::RowVector2d(field.at(c, r)[0], field.at(c, r)[1]);
      }
    }
    if (normal(0, 0) == 0) continue;
    const Eigen::Vector2d mean = normal.block<2, 1>(1, 0) / normal(0, 0);
    const Eigen::Matrix2d spread = normal.block<2, 2>(1, 1) / normal(0, 0) - mean * mean.transpose();
    if (widening >= 3 || spread.determinant() > 1e-3 * std::max(1e-3, spread.trace() * spread.trace())) break;
  }
  // A trace of flatness decides where the samples leave a slope open.
  normal(1, 1) += 1e-9 * normal(0, 0);
  normal(2, 2) += 1e-9 * normal(0, 0);
  const Eigen::Matrix<double, 3, 2> plane = normal.ldlt().solve(right);
  return {plane(0, 0), plane(0, 1)};
}

/// A mesh of so many cells and its error; INFINITY as soon as the error is above `stopAbovePx`.
WarpMesh meshOf(const Field& field, std::int32_t cellsAcross, std::int32_t cellsDown, double stopAbovePx) {
  const Axis across(field.columns, cellsAcross), down(field.rows, cellsDown);
  WarpMesh mesh;
  mesh.columns = cellsAcross + 1;
  mesh.rows = cellsDown + 1;
  mesh.uv.reserve(2 * static_cast<std::size_t>(mesh.columns) * static_cast<std::size_t>(mesh.rows));
  for (std::int32_t row = 0; row < mesh.rows; ++row) {
    for (std::int32_t column = 0; column < mesh.columns; ++column) {
      Point point = interpolated(field, double(column) / cellsAcross, double(row) / cellsDown);
      if (std::isnan(point.u)) point = continued(field, across, down, column, row);
      mesh.uv.push_back(static_cast<float>(point.u));
      mesh.uv.push_back(static_cast<float>(point.v));
    }
  }
  double worst = 0;
  for (std::int32_t r = 0; r < field.rows; ++r) {
    const auto rowIndex = static_cast<std::size_t>(r);
    const double y = down.within[rowIndex];
    const float* upper = mesh.uv.data() + 2 * static_cast<std::size_t>(down.cell[rowIndex]) *
                                              static_cast<std::size_t>(mesh.columns);
    const float* lower = upper + 2 * static_cast<std::size_t>(mesh.columns);
    for (std::int32_t c = 0; c < field.columns; ++c) {
      if (field.isHole(c, r)) continue;
      const double x = across.within[static_cast<std::size_t>(c)];
      const std::size_t left = 2 * static_cast<std::size_t>(across.cell[static_cast<std::size_t>(c)]);
      const auto mix = [&](std::size_t i) {
        return (double{upper[left + i]} * (1 - x) + double{upper[left + 2 + i]} * x) * (1 - y) +
               (double{lower[left + i]} * (1 - x) + double{lower[left + 2 + i]} * x) * y;
      };
      const float* sample = field.at(c, r);
      const double du = (mix(0) - sample[0]) * field.widthPx, dv = (mix(1) - sample[1]) * field.heightPx;
      const double squared = du * du + dv * dv;
      if (!(squared <= worst)) worst = squared;
    }
    if (!(worst <= stopAbovePx * stopAbovePx)) {
      mesh.errorPx = INFINITY;
      return mesh;
    }
  }
  mesh.errorPx = std::sqrt(worst);
  return mesh;
}

/// The least count in [1, enough] that `fits`, which `enough` does.
template <class Fits>
std::int32_t leastThatFits(std::int32_t enough, Fits fits) {
  std::int32_t tooFew = 0;
  while (enough - tooFew > 1) {
    const std::int32_t middle = tooFew + (enough - tooFew) / 2;
    if (fits(middle)) {
      enough = middle;
    } else {
      tooFew = middle;
    }
  }
  return enough;
}

WarpMesh coarsest(const Field& field, double maxErrorPx) {
  const std::int32_t mostAcross = std::min(field.columns, kMaxWarpVertices - 1);
  const std::int32_t mostDown = std::min(field.rows, kMaxWarpVertices - 1);
  const auto fits = [&](std::int32_t across, std::int32_t down) {
    return std::isfinite(meshOf(field, across, down, maxErrorPx).errorPx);
  };
  std::int32_t across = 1, down = 1;
  while (!fits(across, down)) {
    if (across >= mostAcross && down >= mostDown) return meshOf(field, across, down, INFINITY);
    across = std::min(across * 2, mostAcross);
    down = std::min(down * 2, mostDown);
  }
  across = leastThatFits(across, [&](std::int32_t cells) { return fits(cells, down); });
  down = leastThatFits(down, [&](std::int32_t cells) { return fits(across, cells); });
  return meshOf(field, across, down, INFINITY);
}

WarpMesh straight() {
  return {2, 2, {0, 0, 1, 0, 0, 1, 1, 1}, 0};
}

/// Looks past the picture by more than half a pixel.
bool isOutside(const MpcdiRegion& region, float u, float v) {
  const double x = 0.5 / region.widthPx, y = 0.5 / region.heightPx;
  return !(u >= -x && u <= 1 + x && v >= -y && v <= 1 + y);
}

struct Axes {
  explicit Axes(const PictureRectangle& picture)
      : right(picture.lowerRight - picture.lowerLeft),
        up(picture.upperLeft - picture.lowerLeft),
        normal(right.cross(up)) {}
  Vec3 right, up, normal;
};

}  // namespace

WarpMesh warpMeshOf(const MpcdiRegion& region, double maxErrorPx) {
  if (!region.warp) return straight();
  const MpcdiWarp& warp = *region.warp;
  if (warp.isInSpace) return {};
  Field field{warp.columns, warp.rows, {}, double(region.widthPx), double(region.heightPx)};
  field.uv.reserve(warp.xyz.size() / 3 * 2);
  for (std::size_t i = 0; i + 2 < warp.xyz.size(); i += 3) {
    const float u = warp.xyz[i], v = 1 - warp.xyz[i + 1];
    const bool isHole = std::isnan(u) || std::isnan(v);
    field.uv.push_back(isHole ? kNothing : u);
    field.uv.push_back(isHole ? kNothing : v);
  }
  return coarsest(field, maxErrorPx);
}

WarpMesh warpMeshSeenFrom(const MpcdiRegion& region, const Vec3& eye, const PictureRectangle& picture,
                          double maxErrorPx) {
  if (!region.warp || !region.warp->isInSpace) return {};
  const MpcdiWarp& warp = *region.warp;
  const Axes axes(picture);
  const double toPlane = axes.normal.dot(picture.lowerLeft - eye);
  Field field{warp.columns, warp.rows, {}, double(region.widthPx), double(region.heightPx)};
  field.uv.reserve(warp.xyz.size() / 3 * 2);
  for (std::size_t i = 0; i + 2 < warp.xyz.size(); i += 3) {
    const Vec3 ray = Vec3(warp.xyz[i], warp.xyz[i + 1], warp.xyz[i + 2]) - eye;
    const double along = toPlane / axes.normal.dot(ray);
    float u = kNothing, v = kNothing;
    if (along > 0 && std::isfinite(along)) {
      const Vec3 hit = eye + along * ray - picture.lowerLeft;
      u = static_cast<float>(hit.dot(axes.right) / axes.right.squaredNorm());
      v = static_cast<float>(1 - hit.dot(axes.up) / axes.up.squaredNorm());
      // So far out nothing is drawn, and sums must stay finite.
      if (!(std::abs(u) <= 1e6F && std::abs(v) <= 1e6F)) u = v = kNothing;
    }
    field.uv.push_back(u);
    field.uv.push_back(v);
  }
  return coarsest(field, maxErrorPx);
}

MpcdiMap alphaOf(const MpcdiRegion& region) {
  if (!region.warp) return region.alpha;
  const MpcdiWarp& warp = *region.warp;
  const auto showsNothing = [&](std::size_t sample) {
    const float* xyz = warp.xyz.data() + sample * 3;
    if (std::isnan(xyz[0]) || std::isnan(xyz[1]) || (warp.isInSpace && std::isnan(xyz[2]))) return true;
    return !warp.isInSpace && isOutside(region, xyz[0], xyz[1]);
  };
  bool hasHoles = false;
  for (std::size_t sample = 0; sample * 3 < warp.xyz.size() && !hasHoles; ++sample)
    hasHoles = showsNothing(sample);
  if (!hasHoles) return region.alpha;
  MpcdiMap alpha = region.alpha;
  if (alpha.isEmpty()) {
    alpha.widthPx = warp.columns;
    alpha.heightPx = warp.rows;
    alpha.values.assign(warp.xyz.size() / 3, 65535);
  }
  for (std::int32_t y = 0; y < alpha.heightPx; ++y) {
    const auto row =
        static_cast<std::size_t>((2 * std::int64_t{y} + 1) * warp.rows / (2 * std::int64_t{alpha.heightPx}));
    for (std::int32_t x = 0; x < alpha.widthPx; ++x) {
      const auto column = static_cast<std::size_t>((2 * std::int64_t{x} + 1) * warp.columns /
                                                   (2 * std::int64_t{alpha.widthPx}));
      if (showsNothing(row * static_cast<std::size_t>(warp.columns) + column)) {
        alpha.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(alpha.widthPx) +
                     static_cast<std::size_t>(x)] = 0;
      }
    }
  }
  return alpha;
}

Result<PictureRectangle> pictureAround(const MpcdiRegion& region, const Vec3& eye) {
  const auto fail = [&](std::string what) { return inputError("region " + region.id, std::move(what)); };
  if (!region.warp || !region.warp->isInSpace) return fail("has no map of points in space");
  std::vector<Vec3> points;
  Vec3 middle = Vec3::Zero();
  const std::vector<float>& xyz = region.warp->xyz;
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
    const Vec3 point(xyz[i], xyz[i + 1], xyz[i + 2]);
    if (!isFinite(point)) continue;
    points.push_back(point);
    middle += point;
  }
  if (points.empty()) return fail("its map has no point");
  middle /= static_cast<double>(points.size());
  const double distance = lengthOf(middle - eye);
  if (!(distance > 1e-3)) return fail("its points lie around the eye; no flat picture holds them");
  const Vec3 forward = (middle - eye) / distance;
  Vec3 right = forward.cross(Vec3::UnitY());
  if (lengthOf(right) < 1e-6) right = Vec3::UnitX();
  right.normalize();
  const Vec3 up = right.cross(forward);
  double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
  for (const Vec3& point : points) {
    const Vec3 ray = point - eye;
    const double depth = ray.dot(forward);
    const double steepest = 6;  // about 80 degrees
    const double at[2] = {ray.dot(right) / depth, ray.dot(up) / depth};
    if (!(depth > 0) || std::abs(at[0]) > steepest || std::abs(at[1]) > steepest) {
      return fail("its points lie around the eye; no flat picture holds them");
    }
    for (int i = 0; i < 2; ++i) {
      least[i] = std::min(least[i], at[i] * distance);
      most[i] = std::max(most[i], at[i] * distance);
    }
  }
  if (most[0] - least[0] < 1e-3 || most[1] - least[1] < 1e-3)
    return fail("the eye sees its points from the side");
  const Vec3 lowerLeft = middle + right * least[0] + up * least[1];
  return PictureRectangle{lowerLeft, lowerLeft + right * (most[0] - least[0]),
                          lowerLeft + up * (most[1] - least[1])};
}

}  // namespace tessera

#pragma once

#include <cstdint>
#include <initializer_list>

#include "common/scene/synthetic/model.h"

// Pieces that leaves are put together from. All in metres, y up, in the leaf's own frame.
namespace tessera::synthetic {

[[nodiscard]] Part box(const Vec3& min, const Vec3& max);
/// Stands on y = `base.y()`, centred on `base` in x and z; `size` is (x, y, z).
[[nodiscard]] Part blockOn(const Vec3& base, const Vec3& size);
/// Open at both ends.
[[nodiscard]] Part tube(const Vec3& from, const Vec3& to, double radiusM);
/// Closed at both ends.
[[nodiscard]] Part rod(const Vec3& from, const Vec3& to, double radiusM);
/// Body of revolution on `base` with its axis along `axis` (a unit vector).
[[nodiscard]] Part turned(const Vec3& base, std::vector<Curve> profile, const Vec3& axis = Vec3::UnitY());
/// Cylinder with rounded ends along `from`-`to`; the ends bulge out by `endM` more.
[[nodiscard]] Part vessel(const Vec3& from, const Vec3& to, double radiusM, double endM);
/// Torus about the `axis` through `center`.
[[nodiscard]] Part ring(const Vec3& center, double ringRadiusM, double barRadiusM, const Vec3& axis);
/// Disc with a hole for a pipe, from `base` along `axis`.
[[nodiscard]] Part collar(const Vec3& base, double innerM, double outerM, double thickM, const Vec3& axis);
/// H section, open at both ends, web upright where the beam is not.
[[nodiscard]] Part beam(const Vec3& from, const Vec3& to, double depthM, double widthM);
/// Square section from one point to another, open at both ends.
[[nodiscard]] Part bar(const Vec3& from, const Vec3& to, double widthM);
/// Extrudes a polygon (counter-clockwise in x-y from +z) along +z from `placement`.
[[nodiscard]] Part prism(const std::vector<Vec2>& corners, double depthM, const Placement& placement = {});
[[nodiscard]] Part repeated(Part part, std::uint32_t count, const Vec3& stepM);
/// `count` copies spread about the leaf's y axis.
[[nodiscard]] Part around(Part part, std::uint32_t count, double fullRad = 2 * kPi);
/// Keeps all its copies in coarse scenes too.
[[nodiscard]] Part exactly(Part part);
[[nodiscard]] Part fromLevel(Part part, double minLevel);
[[nodiscard]] Part belowLevel(Part part, double maxLevel);

/// Closed outline through the corners.
[[nodiscard]] std::vector<Curve> polygon(const std::vector<Vec2>& corners);
/// Open outline through the points.
[[nodiscard]] std::vector<Curve> polyline(const std::vector<Vec2>& points);

/// Two rails, a toe board and posts.
[[nodiscard]] Parts railing(const Vec3& from, const Vec3& to);
/// Round railing about the y axis.
[[nodiscard]] Parts roundRailing(double radiusM, double heightM);
/// Upright ladder with a safety cage from 2.5 m on; climbs from the origin, its back towards -z.
[[nodiscard]] Parts cagedLadder(double heightM);
/// Walkway of bars in x-z with its top at y = 0, from the origin to (x, z) = size.
[[nodiscard]] Parts grating(const Vec2& sizeM);
/// Open steel stairs that climb along +x from the origin.
[[nodiscard]] Parts steelStairs(double runM, double riseM, double widthM);

void append(Parts& parts, Parts more);
[[nodiscard]] Parts joined(std::initializer_list<Parts> all);

}  // namespace tessera::synthetic

#pragma once

#include <cstdint>
#include <vector>

#include "common/wall/mpcdi/mpcdi.h"

namespace tessera {

/// How a projector's picture is bent: a regular mesh over it, between whose vertices (u, v) runs bilinearly.
struct WarpMesh {
  /// Vertices, 2..4096 each. Vertex (c, r) stands at (c / (columns - 1), r / (rows - 1)) of the projector's
  /// picture from its upper left corner, so the outer ones lie on its edges. 0: there is no mesh.
  std::int32_t columns = 0, rows = 0;
  /// Two floats a vertex, row by row from the top: where in the drawn picture it looks, u from the left and v
  /// from the top, 0..1; a little more near the edges. NaN: nothing is shown around it.
  std::vector<float> uv;
  /// The largest distance, over all samples of the map, from where the mesh looks to where the sample does,
  /// in pixels of a drawn picture as large as the projector's.
  double errorPx = 0;
};

inline constexpr std::int32_t kMaxWarpVertices = 4096;  ///< each way

/// The coarsest regular mesh, by halving and then by trying, that keeps within `maxErrorPx` at every sample
/// of the region's map; where none does, the finest one, a vertex for every sample: errorPx tells. Around
/// holes the mesh goes on as the map does beside them, so that no sample beside a hole is lost; the holes
/// themselves are cut out by alphaOf. Without a map: a mesh that bends nothing. A map of points in space
/// gives no mesh: see warpMeshSeenFrom.
[[nodiscard]] WarpMesh warpMeshOf(const MpcdiRegion& region, double maxErrorPx);

/// Corners of a flat picture in space, metres.
struct PictureRectangle {
  Vec3 lowerLeft, lowerRight, upperLeft;
};

/// The same for a map of points in space (profiles a3 and sl): each looks where the line from the eye through
/// its point meets the picture. Points behind the eye are holes. No mesh where the map is not one of points.
[[nodiscard]] WarpMesh warpMeshSeenFrom(const MpcdiRegion& region, const Vec3& eye,
                                        const PictureRectangle& picture, double maxErrorPx);

/// The factor of light of each of the projector's pixels: the region's alpha map, and 0 where the warp has a
/// hole or, unless it is of points in space, looks past the drawn picture. Empty: 1 everywhere.
[[nodiscard]] MpcdiMap alphaOf(const MpcdiRegion& region);

/// The smallest upright rectangle that all points of the region's map lie in as the eye sees them, at right
/// angles to the line from the eye to their middle and through it. Fails for maps that are not of points, and
/// where the points lie so much around the eye that no flat picture holds them.
[[nodiscard]] Result<PictureRectangle> pictureAround(const MpcdiRegion& region, const Vec3& eye);

}  // namespace tessera

#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/tile_rect.h"
#include "common/hierarchy/grid_coordinates.h"

// Footprints of boxes on a uniform grid, a block at a time, in float with a bound of all errors.
//
// For each box the 8 corners' x, y, z (GridCoordinates) are computed, and where all z are certainly positive
// the box falls on columns [min x/z, max x/z] and rows [min y/z, max y/z], widened by the bound.
//
// Bound, u = 2^-24, F the largest component of a functional, m the sum of the components of |d| and of all
// |h_k|: d = fl32(s fl64(c - eye)) errs by u|d| (and 2^-53|d|), the half-axes by u|h| (rounded once when
// stored); a product and two sums by 3u of the absolute terms; the corner's three sums by 3u more: 7u F m,
// 8u F m is kept, which also covers the rounding of m itself; extent's 2^-96 covers underflow.
//   A tile's border at column b (|b| <= n + 1) is met or passed by a corner with x >= bz; computed, x >= bz -
// (8u Fx m + (n + 1) 8u Fz m), so x/z >= b - (8u Fx + 8u (n + 1) Fz) m / z. The reciprocal (shared by two
// corners), the product and the last sums err by 7u (n + 2) for quotients up to the border, and order is kept
// beyond it. As z <= Fz m (1 + 8u), that is below 8u (n + 2) Fz m / zmin as well. Together:
//
//   error = (8u Fx + 16u (n + 2) Fz) m / zmin
//
// zmin itself is taken from a box only where it is above 256u Fz m, so it is right to 3 %, which the 8u
// cover.
//
// An outline is the union of the box's 12 edges between the projected corners. Far off the wall a quotient q
// errs by 8u Fz |q| m / zmin more and the point at which an edge crosses a row's border by 8u |q|; a rounding
// of y is a crossing with a line beside the one that is meant, so rows are widened by twice the error. With
// 32u Fz |q| m / zmin both are covered.
//
// The same operations in the same order are IEEE arithmetic on every instruction set (no fused
// multiply-add, no approximate reciprocal), so all give the same rectangles.
//
// Boxes that reach behind the eye, or nearly, or whose numbers are too large or small are left to
// ClippedFootprint, unless they are certainly outside one of the wall's sides, near or far.
namespace tessera::cull {

/// What a kernel needs of a frame. The errors of an inner node's box are three times those of a leaf's, so
/// that a node's rectangle, as computed, holds those of all leaves below it, as computed: |d| + |h| of a box
/// is no smaller than that of one within it.
struct KernelFrame {
  double eye[3], scale;
  float column[3], row[3], depth[3];
  float columnError, rowError;  ///< times m / zmin, in tiles
  float frontError;             ///< times m: zmin above that is certainly before the eye
  float depthError;             ///< times m: of comparing z with near and far
  float sideError;              ///< times m: of comparing x or y with a border times z, with much to spare
  /// z of the nearest corner against that of the farthest; m; z: beyond these a box is left open.
  float depthRatio, mostSize, leastDepth;
  float near, far;
  float columnLow, columnHigh, rowLow, rowHigh;
  float valueError;  ///< times m: of x - bz and y - bz
  float farError;    ///< times m / zmin and the largest quotient: of corners and edges far off the wall
  float lastColumn, lastRow;  ///< the largest column and row

  static KernelFrame forLeaves(const GridCoordinates& grid, double scale) { return make(grid, scale, 1); }
  static KernelFrame forNodes(const GridCoordinates& grid, double scale) { return make(grid, scale, 3); }

 private:
  static KernelFrame make(const GridCoordinates& grid, double scale, double errors);
};

/// Where a node's children may be.
struct NodeFootprints {
  TileRect rects[kLanes];
  std::uint32_t contained = 0;  ///< mask: certainly inside the one tile that the rectangle is
  std::uint32_t unknown = 0;    ///< mask: the rectangle says nothing
};

/// Which boxes of a block need more.
struct BlockLanes {
  std::uint16_t open = 0;  ///< mask: neither a rectangle nor certainly outside; the rectangle is kNoTiles
  std::uint16_t wide = 0;  ///< mask: the rectangle has at least two rows and columns and kLeastRefined tiles
};
/// Below that many tiles an outline spares too little.
inline constexpr int kLeastRefined = 9;

/// Certificates hold for borders of the tiles that lie within this of their places, in tiles.
inline constexpr float kBorderSlack = 0x1p-13F;

/// What floats may round off where an expiry is made and checked, times reach + 1: a few roundings of at most
/// reach * turn + travel, which are kept below 8.
inline constexpr float kCheckRounding = 0x1p-17F;

/// How far the camera has drifted in columns and rows (CameraDrift), rounded up.
struct KernelDrift {
  float columnTurn, columnTravel, rowTurn, rowTravel;
};

/// How long the rectangles of a block hold, by lane: while reach * turn + travel is below `columnUntil` and
/// `rowUntil`, with turn and travel of the columns and of the rows. In scaled lengths; -infinity of a lane
/// left open.
struct alignas(64) BlockExpiry {
  float columnUntil[kLanes], rowUntil[kLanes], reach[kLanes];
};

/// One instruction set's kernels.
struct Kernels {
  /// Rectangles of `count` blocks of leaves to rects[count * kLanes].
  void (*leaves)(const KernelFrame&, const OrientedBlock* blocks, std::size_t count, TileRect* rects,
                 BlockLanes* lanes);
  /// The same, and how long they hold.
  void (*leavesCertified)(const KernelFrame&, const OrientedBlock* blocks, std::size_t count, TileRect* rects,
                          BlockLanes* lanes, const KernelDrift& drift, BlockExpiry* expiries);
  /// Masks of the lanes that hold no longer, one for each block.
  void (*expired)(const BlockExpiry* blocks, std::size_t count, const KernelDrift& drift,
                  std::uint16_t* masks);
  /// Masks of the leaves whose rectangle is not the one of the leaf before, one for each block; the first of
  /// a block always counts.
  void (*runs)(const TileRect* rects, std::size_t count, std::uint16_t* masks);
  void (*nodes)(const KernelFrame&, const AlignedBlock& block, NodeFootprints& out);
  /// The columns that the outline of one leaf's box covers in each row of its rectangle `cells`, which
  /// `leaves` found. False where that is the whole rectangle.
  bool (*spans)(const KernelFrame&, const OrientedBlock& block, std::size_t lane, const TileCells& cells,
                ColumnSpan* spans);
};

/// Of the best instruction set here, or of the one that TESSERA_SIMD or chooseInstructionSet names.
[[nodiscard]] const Kernels& kernels();

/// scalar, sse4, avx2, avx512 or neon: those that were built and that this machine has, best first.
[[nodiscard]] std::vector<std::string_view> instructionSets();
/// The one that runs.
[[nodiscard]] std::string_view instructionSet();
/// For tests and measurements; "" is the best. Not while a culler runs. Fails for one that is not here.
[[nodiscard]] Status chooseInstructionSet(std::string_view name);
/// The wish in the environment variable TESSERA_SIMD, if it names one that is not here: to be said once.
[[nodiscard]] Status checkInstructionSetWish();

}  // namespace tessera::cull

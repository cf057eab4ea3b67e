#pragma once

#include "common/hierarchy/grid_coordinates.h"

namespace tessera::cull {

/// How far a camera has moved since some frame, as it bears on the columns and rows of points that stand
/// still, and on near and far.
///
/// x - bz = (A - bF).p changes by ((A' - bF') - (A - bF)).p + (A' - bF').(e - e') when the functionals become
/// A' and F' and the eye e'. A norm of A - bF is convex in b, so over all borders b in [-1, n + 1] it is
/// largest at an end. The sum over frames of what stands before |p| is `turn`, of the rest, and of the
/// changes of near and far, is `travel`: between two frames x - bz changes by at most (turn' - turn) times
/// the largest |p| on the way, plus travel' - travel. As (n + 2) z is the difference of two of them, z
/// changes by at most two thirds of that. The same for rows.
class CameraDrift {
 public:
  struct Axis {
    double turn = 0, travel = 0;
  };

  /// Goes on to a frame. `scale` is that of the boxes' lengths. False where what was before says nothing
  /// about this frame: the first, another grid, or a step that is not finite.
  bool advance(const GridCoordinates& grid, double scale);
  /// Starts to count from here again.
  void rebase() { columns_ = rows_ = {}; }

  [[nodiscard]] const Axis& columns() const { return columns_; }
  [[nodiscard]] const Axis& rows() const { return rows_; }
  [[nodiscard]] double total() const { return columns_.turn + columns_.travel + rows_.turn + rows_.travel; }

 private:
  bool isFirst_ = true;
  GridCoordinates last_;
  Axis columns_, rows_;
};

}  // namespace tessera::cull

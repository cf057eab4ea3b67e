#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "common/cull/culler.h"
#include "common/hierarchy/general_frusta.h"
#include "common/hierarchy/grid_frusta.h"
#include "common/wall/frustum_groups.h"
#include "common/wall/wall.h"

namespace tessera {

/// Culls a scene to a whole wall, whatever its shape: a frustum hierarchy and a culler for each group of
/// tiles (frustumGroups). Lists are in the order of Wall::tiles; in stereo the list of a tile for both eyes
/// holds what either sees. By planes a pair of eyes is culled in one traversal (FrustumHierarchy::holdEyes);
/// by footprints each eye is culled apart, which is faster.
///
/// As cull::Culler: deterministic, not thread-safe, no allocation once warm but for walls in stereo.
class WallCuller {
 public:
  /// `scene` outlives the culler; `options` must pass check().
  WallCuller(const ObjectHierarchy& scene, const Wall& wall, const cull::Options& options,
             PlaneSource source = PlaneSource::Corners);

  /// The frusta of a frame; makes those planes that are read.
  void update(const WallView& view);

  /// The whole lists of the frame of the last update(). The result lives until the next call of any member.
  const cull::Result& cull();
  /// What they change in those of the call before.
  const cull::Changes& cullChanges();
  /// One tile's whole list as of the last call. `out` is cleared and refilled.
  void listOf(std::uint32_t tile, VisibleList& out) const;
  /// What the last call ran for the first group.
  [[nodiscard]] cull::Algorithm picked() const { return groups_.front().culler.picked(); }
  [[nodiscard]] std::size_t groupCount() const { return groups_.size(); }

 private:
  struct Group {
    FrustumGroup what;
    std::optional<GridFrusta> grid;
    GeneralFrusta general;
    cull::Culler culler;
    std::optional<GridFrusta> rightGrid;  ///< eyes apart: `grid` and `culler` are the left one's
    std::optional<cull::Culler> rightCuller;
    std::vector<Frustum> tiles, left, right;  ///< of the frame, where they are not simply the wall's
    [[nodiscard]] const FrustumHierarchy& frusta() const {
      return grid ? static_cast<const FrustumHierarchy&>(*grid) : general;
    }
  };
  struct Place {
    std::uint32_t group, frustum;
  };

  void update(Group& group, const WallView& view);
  void updateApart(Group& group, const WallView& view);
  void cullApart(Group& group);

  std::vector<TileEye> eyes_;  ///< by tile
  bool eyesApart_ = false;
  std::vector<Group> groups_;
  std::vector<Place> places_;  ///< by tile
  bool isPlain_ = false;       ///< one group in the wall's own order: its results are the wall's
  cull::Result result_;
  cull::Changes changes_;
  std::vector<VisibleList> listsBefore_;  ///< of eyes apart
};

}  // namespace tessera

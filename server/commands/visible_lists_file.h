#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/cull/culler.h"
#include "common/scene/scene.h"
#include "common/wall/wall.h"

namespace tessera {

/// Writes visible lists as JSON Lines ("tessera-lists", version 1): a header, then a line a frame with every
/// tile's frustum, whose doubles read back exactly, and its ranges, in leaf ids of the scene's graph. The
/// file appears whole or not at all.
class VisibleListsFile {
 public:
  [[nodiscard]] Status open(const std::filesystem::path& path, const Scene& scene, const Wall& wall);
  void add(std::uint64_t frame, const WallView& view, const cull::Result& lists);
  [[nodiscard]] Status finish();
  VisibleListsFile() = default;
  ~VisibleListsFile();
  VisibleListsFile(const VisibleListsFile&) = delete;
  VisibleListsFile& operator=(const VisibleListsFile&) = delete;

 private:
  std::filesystem::path path_, partial_;
  std::ofstream out_;
  std::vector<Tile> tiles_;
  std::vector<std::string> quotedNames_;
  std::string line_;
  [[nodiscard]] const VisibleList& inGraphOrder(const VisibleList& list);
  std::vector<std::uint32_t> graphLeaves_;  ///< by leaf id; empty where the ids are the graph's
  std::vector<std::uint32_t> graphIds_;
  VisibleList graphList_;
};

}  // namespace tessera

#include "server/commands/visible_lists_file.h"

#include <algorithm>
#include <charconv>

#include <nlohmann/json.hpp>
#include <unistd.h>

namespace tessera {

namespace {

/// The shortest decimal that reads back as the same double.
void appendNumber(std::string& out, double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  out.append(text, end.ptr);
}

void appendVec(std::string& out, const Vec3& v) {
  out += '[';
  for (int i = 0; i < 3; ++i) {
    if (i > 0) out += ',';
    appendNumber(out, v[i]);
  }
  out += ']';
}

void appendFrustum(std::string& out, const Frustum& frustum) {
  out += "\"eye\":";
  appendVec(out, frustum.eye);
  out += ",\"corners\":[";
  for (std::size_t i = 0; i < 4; ++i) {
    if (i > 0) out += ',';
    appendVec(out, frustum.corners[i]);
  }
  const auto appendDistance = [&out](const char* name, const std::optional<double>& distance) {
    out += name;
    if (distance) appendNumber(out, *distance);
    if (!distance) out += "null";
  };
  appendDistance("],\"near\":", frustum.near);
  appendDistance(",\"far\":", frustum.far);
}

void appendList(std::string& out, const VisibleList& list) {
  out += ",\"visible\":[";
  for (std::size_t i = 0; i < list.size(); ++i) {
    const LeafRange range = list[i];
    if (i > 0) out += ',';
    out += "[" + std::to_string(range.first) + "," + std::to_string(range.last) + "]";
  }
  out += "]}";
}

std::string withSuffix(const std::string& quoted, const char* suffix) {
  return quoted.substr(0, quoted.size() - 1) + suffix + '"';
}

}  // namespace

Status VisibleListsFile::open(const std::filesystem::path& path, const Scene& scene, const Wall& wall) {
  path_ = path;
  partial_ = path;
  partial_ += "." + std::to_string(::getpid()) + ".tmp";
  out_.open(partial_, std::ios::binary | std::ios::trunc);
  if (!out_) return inputError(path.string(), "cannot be created", "check the folder of --lists");
  nlohmann::ordered_json names = nlohmann::ordered_json::array();
  tiles_ = wall.tiles;
  const bool isStereo = wall.observer && wall.observer->stereo != Stereo::None;
  for (const Tile& tile : wall.tiles) {
    if (isStereo && tile.eye == TileEye::Both) {
      names.push_back(tile.name + ".left");
      names.push_back(tile.name + ".right");
    } else {
      names.push_back(tile.name);
    }
    quotedNames_.push_back(nlohmann::json(tile.name).dump());
  }
  graphLeaves_.clear();
  for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
    if (scene.leaves[leaf].graphLeaf == leaf && graphLeaves_.empty()) continue;
    if (graphLeaves_.empty()) {
      for (std::uint32_t same = 0; same < leaf; ++same)
        graphLeaves_.push_back(same);
    }
    graphLeaves_.push_back(scene.leaves[leaf].graphLeaf);
  }
  const nlohmann::ordered_json header = {{"format", "tessera-lists"},      {"version", 1},
                                         {"scene", scene.source},          {"wall", wall.source},
                                         {"leaves", scene.graphLeafCount}, {"tiles", names}};
  out_ << header.dump() << '\n';
  return Done{};
}

void VisibleListsFile::add(std::uint64_t frame, const WallView& view, const cull::Result& lists) {
  line_ = "{\"frame\":" + std::to_string(frame) + ",\"tiles\":{";
  for (std::size_t tile = 0; tile < quotedNames_.size(); ++tile) {
    if (tile > 0) line_ += ',';
    const VisibleList& list = inGraphOrder(lists.lists[tile]);
    const auto add = [&](const std::string& quotedName, const Frustum& frustum) {
      line_ += quotedName + ":{";
      appendFrustum(line_, drawnFrustum(tiles_[tile], frustum));
      appendList(line_, list);
    };
    if (view.left.empty()) {
      add(quotedNames_[tile], view.tiles[tile]);
      continue;
    }
    // Of a tile for both eyes: each has a frustum, and they share a list.
    const TileEye eye = tiles_[tile].eye;
    if (eye == TileEye::Both) {
      add(withSuffix(quotedNames_[tile], ".left"), view.left[tile]);
      line_ += ',';
      add(withSuffix(quotedNames_[tile], ".right"), view.right[tile]);
    } else {
      add(quotedNames_[tile], eye == TileEye::Left ? view.left[tile] : view.right[tile]);
    }
  }
  line_ += "}}\n";
  out_ << line_;
}

/// The list in the ids of the scene's graph, whatever hierarchy was culled: a leaf is listed if any part of
/// it is.
const VisibleList& VisibleListsFile::inGraphOrder(const VisibleList& list) {
  if (graphLeaves_.empty()) return list;
  graphIds_.clear();
  forEachLeaf(list, [this](std::uint32_t leaf) { graphIds_.push_back(graphLeaves_[leaf]); });
  std::sort(graphIds_.begin(), graphIds_.end());
  graphIds_.erase(std::unique(graphIds_.begin(), graphIds_.end()), graphIds_.end());
  graphList_.clear();
  for (const std::uint32_t id : graphIds_)
    appendRange(graphList_, {id, id + 1});
  return graphList_;
}

Status VisibleListsFile::finish() {
  out_.close();
  std::error_code ec;
  if (out_) std::filesystem::rename(partial_, path_, ec);
  if (!out_ || ec) return runtimeError(path_.string(), "cannot be written", "is the disk full?");
  partial_.clear();
  return Done{};
}

VisibleListsFile::~VisibleListsFile() {
  std::error_code ignored;
  if (!partial_.empty()) std::filesystem::remove(partial_, ignored);
}

}  // namespace tessera

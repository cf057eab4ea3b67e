#include "server/commands/visible_lists_file.h"

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

}  // namespace

Status VisibleListsFile::open(const std::filesystem::path& path, const Scene& scene, const Wall& wall) {
  path_ = path;
  partial_ = path;
  partial_ += "." + std::to_string(::getpid()) + ".tmp";
  out_.open(partial_, std::ios::binary | std::ios::trunc);
  if (!out_) return inputError(path.string(), "cannot be created", "check the folder of --lists");
  nlohmann::ordered_json names = nlohmann::ordered_json::array();
  for (const Tile& tile : wall.tiles) {
    names.push_back(tile.name);
    quotedNames_.push_back(nlohmann::json(tile.name).dump());
  }
  const nlohmann::ordered_json header = {{"format", "tessera-lists"},     {"version", 1},
                                         {"scene", scene.source},         {"wall", wall.source},
                                         {"leaves", scene.leaves.size()}, {"tiles", names}};
  out_ << header.dump() << '\n';
  return Done{};
}

void VisibleListsFile::add(std::uint64_t frame, const WallView& view, const cull::Result& lists) {
  line_ = "{\"frame\":" + std::to_string(frame) + ",\"tiles\":{";
  for (std::size_t tile = 0; tile < quotedNames_.size(); ++tile) {
    if (tile > 0) line_ += ',';
    line_ += quotedNames_[tile] + ":{";
    appendFrustum(line_, view.tiles[tile]);
    line_ += ",\"visible\":[";
    for (std::size_t i = 0; i < lists.lists[tile].size(); ++i) {
      const LeafRange range = lists.lists[tile][i];
      if (i > 0) line_ += ',';
      line_ += "[" + std::to_string(range.first) + "," + std::to_string(range.last) + "]";
    }
    line_ += "]}";
  }
  line_ += "}}\n";
  out_ << line_;
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

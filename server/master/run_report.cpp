#include "server/master/run_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "common/base/host.h"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

constexpr double k60HzPercentMs = 1000.0 / 60 / 100;

Json spread(const Samples& samples) {
  return {{"p50", samples.percentile(50)}, {"p99", samples.percentile(99)}, {"max", samples.max()}};
}

const char* nameOf(proto::OnMiss onMiss) {
  return onMiss == proto::OnMiss::Wait ? "wait" : onMiss == proto::OnMiss::Box ? "box" : "skip";
}

Json tileJson(const RunReport::TileEntry& tile) {
  Samples drawMs;
  for (const std::uint32_t us : tile.counts.drawUs.values)
    drawMs.add(us / 1000.0);
  return {{"frames_shown", tile.counts.framesShown},
          {"frames_missed", tile.counts.framesMissed},
          {"visible_leaves", spread(tile.visibleLeaves)},
          {"draw_ms", spread(drawMs)},
          {"received_bytes", tile.listBytes + tile.geometryBytes},
          {"received_list_bytes", tile.listBytes},
          {"received_geometry_bytes", tile.geometryBytes},
          {"cache_hits", tile.cacheHits},
          {"cache_misses", tile.cacheMisses},
          {"cache_evictions", tile.cacheEvictions},
          {"disk_hits", tile.diskHits},
          {"disk_lacked", tile.counts.disksLacked},
          {"predicted_geometry_bytes", tile.predictedBytes},
          {"frames_incomplete", tile.counts.framesIncomplete},
          {"missing_leaves", tile.counts.missingLeaves},
          {"missing_px", tile.counts.missingPx},
          {"reconnects", tile.counts.reconnects},
          {"peak_resident_bytes", tile.counts.peakResidentBytes}};
}

}  // namespace

template <class Visit>
void RunReport::forEachSamples(Visit visit) {
  for (Samples* samples :
       {&updateMs, &cullMs, &encodeMs, &sendMs, &tileWaitMs, &swapMs, &masterMs, &frameMs, &listBytesPerFrame,
        &geometryBytesPerFrame, &poseBytesPerFrame, &visibleLeavesPerFrame, &trianglesPerFrame})
    visit(*samples);
  for (TileEntry& tile : tiles)
    visit(tile.visibleLeaves);
}

void RunReport::expect(std::size_t count) {
  forEachSamples([count](Samples& samples) { samples.values.reserve(count); });
}

void RunReport::keepLast(std::size_t count) {
  forEachSamples([count](Samples& samples) { samples.keepLast(count); });
}

double Samples::percentile(double p) const {
  if (values.empty()) return 0;
  std::vector<double> sorted = values;
  const auto rank = static_cast<std::size_t>(std::ceil(p / 100 * static_cast<double>(sorted.size())));
  const std::size_t index = rank == 0 ? 0 : rank - 1;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(index), sorted.end());
  return sorted[index];
}

std::string RunReport::json() const {
  Json tilesJson = Json::object();
  for (const TileEntry& tile : tiles)
    tilesJson[tile.name] = tileJson(tile);
  const Json report = {
      {"format", "tessera-report"},
      {"version", 1},
      {"scene",
       {{"file", scene},
        {"leaves", leaves},
        {"triangles", triangles},
        {"assets", assets},
        {"asset_bytes", assetBytes}}},
      {"wall", wall},
      {"mode",
       {{"algorithm", algorithm},
        {"picked", picked},
        {"bounds", bounds},
        {"hierarchy", hierarchy},
        {"mtpl", maxTrianglesPerLeaf},
        {"switches", switches},
        {"animate", motion.animate},
        {"animation_fps", motion.framesPerSecond},
        {"quantize_motion_m", motion.quantizeBoundM},
        {"measured_error_leaves", 0},
        {"measured_error_px", warpErrorPx}}},
      {"frames", frames},
      {"seconds", seconds},
      {"frames_per_second", seconds > 0 && frames > 1 ? static_cast<double>(frames - 1) / seconds : 0.0},
      {"first_frame_ms", firstFrameMs},
      {"master_peak_resident_bytes", peakResidentBytes()},
      {"frames_incomplete", framesIncomplete},
      {"streaming",
       {{"on_miss", nameOf(stream.onMiss)},
        {"upload_budget_bytes", stream.uploadBytes},
        {"upload_budget_ms", stream.uploadMs},
        {"predict_frames", stream.predictFrames}}},
      {"stages_ms",
       {{"update", spread(updateMs)},
        {"cull", spread(cullMs)},
        {"encode", spread(encodeMs)},
        {"send", spread(sendMs)},
        {"tile_wait", spread(tileWaitMs)},
        {"swap", spread(swapMs)},
        {"master", spread(masterMs)}}},
      {"frame_ms", spread(frameMs)},
      {"master_share_of_60hz_percent",
       {{"p50", masterMs.percentile(50) / k60HzPercentMs},
        {"p99", masterMs.percentile(99) / k60HzPercentMs},
        {"max", masterMs.max() / k60HzPercentMs}}},
      {"visible_pairs_per_frame", spread(visibleLeavesPerFrame)},
      {"sent_bytes_per_frame",
       {{"lists", spread(listBytesPerFrame)},
        {"geometry", spread(geometryBytesPerFrame)},
        {"poses", spread(poseBytesPerFrame)}}},
      {"swap_skew_us", swapSkewUs.values.empty() ? Json(nullptr) : spread(swapSkewUs)},
      {"pictures", {{"written", pictures}, {"incomplete", incompletePictures}}},
      {"tiles", tilesJson}};
  return report.dump(1) + "\n";
}

std::string RunReport::frameLog() const {
  std::string log;
  for (std::size_t i = 0; i < frameMs.values.size(); ++i) {
    log += Json{{"frame", i + 1},
                {"ms", frameMs.values[i]},
                {"pairs", visibleLeavesPerFrame.values[i]},
                {"list_bytes", listBytesPerFrame.values[i]},
                {"geometry_bytes", geometryBytesPerFrame.values[i]},
                {"triangles", trianglesPerFrame.values[i]}}
               .dump() +
           "\n";
  }
  return log;
}

void addSwapSkew(RunReport& report, const std::vector<std::vector<ShownTime>>& shownByTile) {
  struct Span {
    std::int64_t first, last;
    int tiles;
  };
  std::map<std::uint64_t, Span> frames;
  for (const auto& times : shownByTile) {
    for (const ShownTime& shown : times) {
      auto [entry, isNew] = frames.try_emplace(shown.frame, Span{shown.ns, shown.ns, 0});
      Span& span = entry->second;
      span.first = std::min(span.first, shown.ns);
      span.last = std::max(span.last, shown.ns);
      ++span.tiles;
    }
  }
  for (const auto& [frame, span] : frames) {
    if (span.tiles > 1) report.swapSkewUs.add(static_cast<double>(span.last - span.first) / 1000.0);
  }
}

}  // namespace tessera

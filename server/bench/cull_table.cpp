#include "server/bench/cull_table.h"

#include <algorithm>

#include "server/bench/candidates.h"
#include "server/bench/list_checks.h"

namespace tessera::bench {

namespace {

/// Lists are read back and compared in about so many frames.
constexpr std::uint64_t kComparedFrames = 64;

/// True for about `wanted` of the frames, evenly spread.
bool isTaken(std::uint64_t frame, std::uint64_t frames, std::uint64_t wanted) {
  return wanted > 0 && (frame + 1) % std::max<std::uint64_t>(1, frames / wanted) == 0;
}

const InterleavedCull::Measured* find(const InterleavedCull& interleaved, const char* name) {
  for (const auto& measured : interleaved.measured()) {
    if (measured.name == name) return &measured;
  }
  return nullptr;
}

Json pickedOf(const InterleavedCull::Measured& measured) {
  Json frames = Json::object();
  for (std::size_t i = 0; i < measured.picked.size(); ++i) {
    if (measured.picked[i] > 0)
      frames[std::string(cull::nameOf(static_cast<cull::Algorithm>(i)))] = measured.picked[i];
  }
  return frames;
}

Json entriesOf(const CandidateSet& set, const InterleavedCull& interleaved, const ListChecks& checks) {
  Json entries = Json::array();
  const auto& all = interleaved.measured();
  const auto *oh = find(interleaved, kOhName), *linear = find(interleaved, kLinearName);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Json entry = summaryOf(all[i], &all[0].us);
    if (oh) entry["time_ratio_to_oh"] = ratioOf(all[i].us, oh->us);
    if (linear) entry["time_ratio_to_linear_read"] = ratioOf(all[i].us, linear->us);
    if (interleaved.hasLists(i)) {
      entry["threads"] = set.specs()[i].options.threads;
      entry["picked_frames"] = pickedOf(all[i]);
    }
    checks.addTo(entry, i);
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

Result<Json> cullTable(const Scene& scene, const Wall& wall, const CameraPath& path,
                       const CullTableOptions& options) {
  auto specs = selectCandidates(options.only, options.withHierarchies);
  if (!specs) return specs.error();
  const auto made = CandidateSet::make(scene, options.up, std::move(*specs));
  if (!made) return made.error();
  CandidateSet& set = **made;
  const Walk walk(wall, path, scene.sphere(), options.frames);
  WallFrusta frusta(wall);
  InterleavedCull interleaved(set.candidates());
  ListChecks checks(scene, set, interleaved);
  const std::uint64_t frames =
      options.firstFrames == 0 ? walk.frames() : std::min(options.firstFrames, walk.frames());
  for (std::uint64_t frame = 0; frame < frames; ++frame) {
    const WallView view = walk.view(frame);
    frusta.update(view);
    set.setView(view);
    interleaved.frame(frusta.get());
    if (isTaken(frame, frames, kComparedFrames)) {
      if (Status status = checks.compare(frame); !status) return status.error();
    }
    if (isTaken(frame, frames, options.auditedFrames)) {
      if (Status status = checks.judge(frame, view); !status) return status.error();
    }
  }
  return Json{{"scene", scene.source},
              {"leaves", scene.leaves.size()},
              {"wall", wall.source},
              {"tiles", wall.tiles.size()},
              {"frames", frames},
              {"camera_step", stepOf(walk)},
              {"compared_frames", checks.comparedFrames()},
              {"audited_frames", checks.auditedFrames()},
              {"audited_exact_pairs", checks.exactPairs()},
              {"audited_drops", 0},  // a drop is an error
              {"candidates", entriesOf(set, interleaved, checks)}};
}

}  // namespace tessera::bench

#include "server/bench/list_checks.h"

#include <algorithm>

namespace tessera::bench {

namespace {

using cull::Algorithm;

bool goesByFootprints(Algorithm algorithm) {
  return algorithm == Algorithm::Footprint || algorithm == Algorithm::Table || algorithm == Algorithm::Auto;
}

std::vector<std::size_t> withLists(const InterleavedCull& interleaved) {
  std::vector<std::size_t> listing;
  for (std::size_t i = 0; i < interleaved.measured().size(); ++i) {
    if (interleaved.hasLists(i)) listing.push_back(i);
  }
  return listing;
}

}  // namespace

ListChecks::ListChecks(const Scene& scene, const CandidateSet& set, const InterleavedCull& interleaved)
    : scene_(scene),
      set_(set),
      interleaved_(interleaved),
      listing_(withLists(interleaved)),
      hashes_(set.specs().size(), 0),
      auditedPairs_(set.specs().size(), 0),
      lists_(set.specs().size()),
      audit_(scene, listing_.size()) {}

Status ListChecks::compare(std::uint64_t frame) {
  ++comparedFrames_;
  std::map<Kind, First> firsts;
  for (const std::size_t i : listing_) {
    std::vector<VisibleList>& lists = lists_[i];
    interleaved_.listsOf(i, lists);
    const std::uint64_t hash = cull::hashOf(lists, 0);
    hashes_[i] = cull::hashOf(lists, hashes_[i]);
    const CandidateSpec& spec = set_.specs()[i];
    // Where auto has chosen to go by planes, its lists are adaptive's.
    if (!goesByFootprints(spec.options.algorithm) || !goesByFootprints(interleaved_.picked(i))) continue;
    const Kind kind = {spec.options.bounds, spec.options.switches.refine, spec.hierarchy};
    const First& first = firsts.try_emplace(kind, First{i, hash}).first->second;
    if (first.hash == hash) continue;
    return runtimeError(scene_.source,
                        "in frame " + std::to_string(frame) + " the lists of \"" + spec.name +
                            "\" are not those of \"" + set_.specs()[first.candidate].name + "\"",
                        "this is a bug");
  }
  return Done{};
}

Status ListChecks::judge(std::uint64_t frame, const WallView& view) {
  ++auditedFrames_;
  std::vector<const std::vector<VisibleList>*> lists;
  for (const std::size_t i : listing_) {
    interleaved_.listsOf(i, lists_[i]);
    set_.toGraphIds(i, lists_[i]);
    lists.push_back(&lists_[i]);
  }
  for (std::size_t i = 0; i < auditedPairs_.size(); ++i)
    auditedPairs_[i] += static_cast<std::uint64_t>(interleaved_.measured()[i].pairs.values.back());
  if (Status status = audit_.add(frame, view, lists); !status) return status;
  for (std::size_t at = 0; at < listing_.size(); ++at) {
    const Audit::Verdict& verdict = audit_.verdicts()[at];
    if (verdict.drops == 0) continue;
    return runtimeError(scene_.source,
                        "a visible leaf is missing in the lists of \"" + set_.specs()[listing_[at]].name +
                            "\": " + verdict.firstDrop,
                        "this is a bug");
  }
  return Done{};
}

void ListChecks::addTo(Json& entry, std::size_t candidate) const {
  if (auditedFrames_ > 0) entry["audited_pairs"] = auditedPairs_[candidate];
  if (!interleaved_.hasLists(candidate)) return;
  entry["compared_lists_hash"] = hashes_[candidate];
  if (auditedFrames_ == 0) return;
  const auto at = std::find(listing_.begin(), listing_.end(), candidate) - listing_.begin();
  const Audit::Verdict& verdict = audit_.verdicts()[static_cast<std::size_t>(at)];
  entry["audited_drops"] = verdict.drops;
  entry["excess_percent"] = verdict.excessPercent();
}

}  // namespace tessera::bench

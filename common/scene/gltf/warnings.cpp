#include "common/scene/gltf/warnings.h"

#include <algorithm>
#include <utility>

namespace tessera::gltf {

namespace {
constexpr std::size_t kKeptPerKind = 5;
}  // namespace

void Warnings::add(std::string_view kind, std::string sentence) {
  auto it = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& k) { return k.name == kind; });
  if (it == kinds_.end()) it = kinds_.insert(kinds_.end(), Kind{std::string(kind), {}, 0});
  if (it->kept.size() < kKeptPerKind) {
    it->kept.push_back(std::move(sentence));
  } else {
    ++it->dropped;
  }
}

std::vector<std::string> Warnings::sentences() const {
  std::vector<std::string> all;
  for (const Kind& kind : kinds_) {
    all.insert(all.end(), kind.kept.begin(), kind.kept.end());
    if (kind.dropped > 0) all.push_back(std::to_string(kind.dropped) + " more of the kind: " + kind.name);
  }
  return all;
}

}  // namespace tessera::gltf

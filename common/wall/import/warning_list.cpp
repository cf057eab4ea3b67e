#include "common/wall/import/warning_list.h"

#include <algorithm>

namespace tessera {

void WarningList::add(const std::string& kind, int line, const std::string& why) {
  // Kinds that come from a hostile file's own words stay few.
  constexpr std::size_t kMostKinds = 64;
  auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.kind == kind; });
  if (entry == entries_.end() && entries_.size() >= kMostKinds) {
    const std::string rest = "further kinds";
    entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.kind == rest; });
    if (entry == entries_.end()) {
      entries_.push_back({rest, "not a part of a wall; left out", line, 0});
      entry = entries_.end() - 1;
    }
  } else if (entry == entries_.end()) {
    entries_.push_back({kind, why, line, 0});
    entry = entries_.end() - 1;
  }
  ++entry->count;
}

std::vector<std::string> WarningList::texts(const std::string& sourceName) const {
  std::vector<std::string> texts;
  for (const Entry& entry : entries_) {
    std::string text =
        sourceName + (entry.line > 0 ? ':' + std::to_string(entry.line) : std::string()) + ": " + entry.kind;
    if (entry.count > 1) text += " (" + std::to_string(entry.count) + " times)";
    text += ": " + entry.why;
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
    texts.push_back(std::move(text));
  }
  return texts;
}

}  // namespace tessera

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tessera::test {

/// What a mutant may try to reach besides itself.
struct Bait {
  std::vector<std::string> paths;  ///< files that no import may open
  std::string url;                 ///< a server that no import may ask
};

struct Mutant {
  std::string bytes;
  std::string what;  ///< what was done, for people
};

/// A damaged or hostile copy of a scene file, the same for the same seed. Any file gets flipped bytes, is cut
/// short, or has blocks doubled, left out or moved. Files of text and the JSON in glTF files also get numbers
/// and strings that nobody expects, values that change places, vanish or nest deeply; a GLB's lengths are
/// then made to fit, so that its JSON is read.
[[nodiscard]] Mutant mutateScene(const std::string& bytes, const std::string& extension, std::uint64_t seed,
                                 const Bait& bait);

}  // namespace tessera::test

#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::gltf {

/// Gathers warnings; of each kind the first few are kept word for word and the rest are counted, so that a
/// file with a million faults does not make a million sentences.
class Warnings {
 public:
  /// `kind` groups sentences ("primitive skipped"); `sentence` ends without a final stop.
  void add(std::string_view kind, std::string sentence);

  /// All sentences, kinds in the order of their first appearance.
  [[nodiscard]] std::vector<std::string> sentences() const;

 private:
  struct Kind {
    std::string name;
    std::vector<std::string> kept;
    std::size_t dropped = 0;
  };
  std::vector<Kind> kinds_;
};

}  // namespace tessera::gltf

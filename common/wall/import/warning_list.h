#pragma once

#include <string>
#include <vector>

namespace tessera {

/// What an import leaves out or assumes: one line for each kind, with its count and the first place.
class WarningList {
 public:
  /// `kind` says what was met and `why` what becomes of it; a kind keeps the `why` it came with first.
  void add(const std::string& kind, int line, const std::string& why);
  /// "FILE:LINE: KIND (3 times): WHY", in the order of first meeting; line 0: without a line.
  [[nodiscard]] std::vector<std::string> texts(const std::string& sourceName) const;

 private:
  struct Entry {
    std::string kind, why;
    int line = 0, count = 0;
  };
  std::vector<Entry> entries_;
};

}  // namespace tessera

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace tessera {

/// One "key value" of an Equalizer file; a value is a word, a text in quotes, a number, a list in brackets or
/// parentheses, or a block of further ones in braces.
struct EqualizerNode {
  enum class Kind : std::uint8_t { Word, Text, Number, List, Block };

  std::string key;
  int line = 0;  ///< of the key, counted from 1
  Kind kind = Kind::Block;
  std::string text;                ///< of a word, a text and a number
  double number = 0;               ///< finite
  std::vector<double> numbers;     ///< of a list: its numbers
  std::vector<std::string> words;  ///< of a list: its words and texts
  std::vector<EqualizerNode> children;

  /// The last one of that key, for a later one overrules an earlier; null: none.
  [[nodiscard]] const EqualizerNode* find(std::string_view childKey) const;
};

/// Parses the whole of an Equalizer file into a block without a key. Blocks nest 32 deep at most.
[[nodiscard]] Result<EqualizerNode> parseEqualizer(std::string_view text, const std::string& sourceName);

}  // namespace tessera

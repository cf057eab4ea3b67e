#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "common/wall/json_document.h"

namespace tessera {

/// Inclusive.
struct NumberRange {
  double least;
  double most;
};

/// Takes values of known types out of a JsonDocument. The first error sticks and every later call is
/// harmless, so a file's reader asks for all it wants and looks at error() at the end.
class JsonReader {
 public:
  explicit JsonReader(std::string sourceName) : source_(std::move(sourceName)) {}

  [[nodiscard]] bool ok() const { return !error_; }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }
  void fail(int line, std::string what, std::string mend = {});
  /// Says which of many like parts the error lies in.
  void prefixError(const std::string& prefix);

  /// Holds if `value` is an object with no other keys than `knownKeys`; an unknown key is told with the
  /// nearest known one.
  bool object(const JsonValue& value, std::string_view label,
              std::initializer_list<std::string_view> knownKeys);
  /// Holds if `value` is an array.
  bool array(const JsonValue& value, std::string_view label);
  /// The member of that name; its absence is an error.
  std::optional<JsonValue> required(const JsonValue& object, std::string_view objectLabel,
                                    std::string_view key);

  double number(const JsonValue& value, std::string_view label, NumberRange range);
  /// A whole number; 3.0 is one.
  int integer(const JsonValue& value, std::string_view label, NumberRange range);
  std::string string(const JsonValue& value, std::string_view label, std::size_t longestBytes);
  /// An array of `count` numbers; as many zeros where it is none.
  std::vector<double> numbers(const JsonValue& value, std::string_view label, std::size_t count,
                              NumberRange range);
  /// One of the words, as its place among them; another word is told with the nearest of them.
  std::size_t choice(const JsonValue& value, std::string_view label,
                     std::initializer_list<std::string_view> words);
  /// An array of three numbers.
  Vec3 vec3(const JsonValue& value, std::string_view label, NumberRange range);

 private:
  std::string source_;
  std::optional<Error> error_;
};

/// `number` in its shortest form that reads back exactly, whatever the locale.
[[nodiscard]] std::string numberText(double number);

/// The word of `known` with the least edit distance to `word`; ties go to the first.
[[nodiscard]] std::string_view nearestWord(std::string_view word,
                                           std::initializer_list<std::string_view> known);

}  // namespace tessera

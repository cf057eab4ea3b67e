#include "common/wall/json_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <vector>

namespace tessera {

namespace {

/// More of a word is no choice, whatever it says.
constexpr std::size_t kMostChoiceBytes = 1024;

std::string_view kindName(JsonKind kind) {
  switch (kind) {
    case JsonKind::Null:
      return "null";
    case JsonKind::Boolean:
      return "a truth value";
    case JsonKind::Number:
      return "a number";
    case JsonKind::String:
      return "a string";
    case JsonKind::Array:
      return "an array";
    case JsonKind::Object:
      return "an object";
  }
  return "";
}

std::string quoted(std::string_view word) {
  return '"' + std::string(word) + '"';
}

std::string expected(std::string_view label, std::string_view wanted, const JsonValue& value) {
  return quoted(label) + " must be " + std::string(wanted) + ", not " + std::string(kindName(value.kind()));
}

std::string rangeText(NumberRange range) {
  return numberText(range.least) + " to " + numberText(range.most);
}

/// Levenshtein's, one row of the table at a time.
std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string numberText(double number) {
  char text[32];
  const std::to_chars_result end = std::to_chars(std::begin(text), std::end(text), number);
  return {text, end.ptr};
}

std::string_view nearestWord(std::string_view word, std::initializer_list<std::string_view> known) {
  std::string_view nearest;
  std::size_t least = std::string_view::npos;
  for (const std::string_view candidate : known) {
    const std::size_t distance = editDistance(word, candidate);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

void JsonReader::fail(int line, std::string what, std::string mend) {
  if (error_) return;
  error_ = inputError(source_ + ":" + std::to_string(line), std::move(what), std::move(mend));
}

void JsonReader::prefixError(const std::string& prefix) {
  if (error_) error_->what.insert(0, prefix);
}

bool JsonReader::object(const JsonValue& value, std::string_view label,
                        std::initializer_list<std::string_view> knownKeys) {
  if (value.kind() != JsonKind::Object) {
    fail(value.line(), expected(label, "an object", value));
    return false;
  }
  for (const JsonValue& member : value.children()) {
    if (std::find(knownKeys.begin(), knownKeys.end(), member.key()) != knownKeys.end()) continue;
    constexpr std::size_t kLongestKeyBytes = 64;  // as much as is compared and shown of a hostile one
    const std::string key = excerpt(member.key(), kLongestKeyBytes);
    std::string all;
    for (const std::string_view known : knownKeys)
      all += (all.empty() ? "" : ", ") + std::string(known);
    fail(member.keyLine(), "unknown key " + quoted(key) + " in " + quoted(label),
         "did you mean " + quoted(nearestWord(key, knownKeys)) + "? Known keys: " + all);
    return false;
  }
  return true;
}

bool JsonReader::array(const JsonValue& value, std::string_view label) {
  if (value.kind() == JsonKind::Array) return true;
  fail(value.line(), expected(label, "an array", value));
  return false;
}

std::optional<JsonValue> JsonReader::required(const JsonValue& object, std::string_view objectLabel,
                                              std::string_view key) {
  std::optional<JsonValue> member = object.find(key);
  if (!member) fail(object.line(), quoted(objectLabel) + " lacks " + quoted(key), "add it");
  return member;
}

double JsonReader::number(const JsonValue& value, std::string_view label, NumberRange range) {
  if (value.kind() != JsonKind::Number) {
    fail(value.line(), expected(label, "a number", value));
    return range.least;
  }
  const double number = value.number();
  if (number >= range.least && number <= range.most) return number;
  fail(value.line(), quoted(label) + " must be from " + rangeText(range) + ", not " + numberText(number));
  return range.least;
}

int JsonReader::integer(const JsonValue& value, std::string_view label, NumberRange range) {
  const double number = value.number();
  if (value.kind() == JsonKind::Number && number == std::floor(number) && number >= range.least &&
      number <= range.most) {
    return static_cast<int>(number);
  }
  const std::string wanted = "a whole number from " + rangeText(range);
  if (value.kind() != JsonKind::Number) {
    fail(value.line(), expected(label, wanted, value));
  } else {
    fail(value.line(), quoted(label) + " must be " + wanted + ", not " + numberText(number));
  }
  return static_cast<int>(range.least);
}

std::string JsonReader::string(const JsonValue& value, std::string_view label, std::size_t longestBytes) {
  if (value.kind() != JsonKind::String) {
    fail(value.line(), expected(label, "a string", value));
    return {};
  }
  if (value.string().size() > longestBytes) {
    fail(value.line(), quoted(label) + " is longer than " + std::to_string(longestBytes) + " bytes");
    return {};
  }
  return std::string(value.string());
}

std::vector<double> JsonReader::numbers(const JsonValue& value, std::string_view label, std::size_t count,
                                        NumberRange range) {
  std::vector<double> all(count, 0.0);
  if (!array(value, label)) return all;
  const std::vector<JsonValue> elements = value.children();
  if (elements.size() != count) {
    fail(value.line(), quoted(label) + " must be an array of " + std::to_string(count) + " numbers, not of " +
                           std::to_string(elements.size()));
    return all;
  }
  for (std::size_t i = 0; i < count; ++i)
    all[i] = number(elements[i], label, range);
  return all;
}

std::size_t JsonReader::choice(const JsonValue& value, std::string_view label,
                               std::initializer_list<std::string_view> words) {
  constexpr std::size_t kLongestWordBytes = 64;
  const std::string word = excerpt(string(value, label, kMostChoiceBytes), kLongestWordBytes);
  const auto found = std::find(words.begin(), words.end(), word);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  std::string all;
  for (const std::string_view known : words)
    all += (all.empty() ? "" : ", ") + std::string(known);
  fail(value.line(), quoted(label) + " cannot be " + quoted(word),
       "did you mean " + quoted(nearestWord(word, words)) + "? It is one of: " + all);
  return 0;
}

Vec3 JsonReader::vec3(const JsonValue& value, std::string_view label, NumberRange range) {
  const std::vector<double> v = numbers(value, label, 3, range);
  return {v[0], v[1], v[2]};
}

}  // namespace tessera

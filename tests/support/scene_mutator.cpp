#include "tests/support/scene_mutator.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <random>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace tessera::test {

namespace {

constexpr std::size_t kGlbHeader = 12, kChunkHeader = 8;

/// A value in a text: [begin, end). Elements of one array, and members of one object, share their parent.
struct Span {
  std::size_t begin = 0, end = 0;
  std::size_t parent = 0;
  std::uint32_t key =
      0;  ///< numbers the word before it: the key of a member, of the array around it, a field
};

/// Where the values of a text stand: of JSON, or the words of any other text.
struct Values {
  std::vector<Span> numbers, strings, all;
};

bool isWordEnd(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0 || std::strchr(",:[]{}()/", c) != nullptr;
}

/// Of JSON that is in order; of other texts the numbers and the quoted strings.
Values valuesOf(std::string_view text) {
  Values values;
  std::unordered_map<std::string_view, std::uint32_t> keys;
  std::uint32_t key = 0;
  const auto setKey = [&](std::string_view word) {
    key = keys.try_emplace(word, static_cast<std::uint32_t>(keys.size())).first->second;
  };
  std::vector<std::size_t> open;  // starts of the containers around
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t begin = i;
    const std::size_t parent = open.empty() ? 0 : open.back();
    if (text[i] == '"') {
      for (++i; i < text.size() && text[i] != '"' && text[i] != '\n'; ++i)
        i += text[i] == '\\' ? 1 : 0;
      i = std::min(i + 1, text.size());
      if (i < text.size() && text[i] == ':') {
        setKey(text.substr(begin, i - begin));
        continue;
      }
      values.strings.push_back({begin, i, parent, key});
      values.all.push_back(values.strings.back());
    } else if (text[i] == '-' || text[i] == '.' || std::isdigit(static_cast<unsigned char>(text[i])) != 0) {
      while (i < text.size() && !isWordEnd(text[i]))
        ++i;
      if (i == begin) ++i;
      values.numbers.push_back({begin, i, parent, key});
      values.all.push_back(values.numbers.back());
    } else if (text[i] == '[' || text[i] == '{') {
      open.push_back(i++);
    } else if ((text[i] == ']' || text[i] == '}') && !open.empty()) {
      const std::size_t start = open.back();
      open.pop_back();
      values.all.push_back({start, ++i, open.empty() ? 0 : open.back(), key});
    } else if (isWordEnd(text[i])) {
      ++i;
    } else {
      while (i < text.size() && !isWordEnd(text[i]) && text[i] != '"')
        ++i;
      setKey(text.substr(begin, i - begin));
    }
  }
  return values;
}

bool isIndex(std::string_view value) {
  return value.find_first_not_of("0123456789") == std::string_view::npos && value.size() < 7;
}
bool isFileName(std::string_view value) {
  return value.find_first_of("./") != std::string_view::npos;
}

class Mutator {
 public:
  Mutator(std::uint64_t seed, const Bait& bait) : random_(seed), bait_(bait) {}

  std::uint64_t below(std::uint64_t n) { return n == 0 ? 0 : random_() % n; }
  [[nodiscard]] const std::string& what() const { return what_; }

  void mutateBytes(std::string& bytes) {
    if (bytes.empty()) return;
    const std::size_t at = below(bytes.size());
    const std::size_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 1 + below(4096)));
    switch (below(6)) {
      case 0:
      case 1: {
        const std::uint64_t count = 1 + below(16);
        for (std::uint64_t i = 0; i < count; ++i) {
          // Headers and structure stand in front: half of the flips go there.
          const std::size_t where =
              below(below(2) == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 512));
          bytes[where] = static_cast<char>(below(2) == 0 ? bytes[where] ^ (1 << below(8)) : below(256));
        }
        return note("flipped " + std::to_string(count) + " bytes");
      }
      case 2:
        bytes.resize(at);
        return note("cut at " + std::to_string(at));
      case 3:
        bytes.insert(at, bytes.substr(at, length));
        return note("doubled a block at " + std::to_string(at));
      case 4:
        bytes.erase(at, length);
        return note("left out a block at " + std::to_string(at));
      default: {
        const std::string block = bytes.substr(at, length);
        bytes.erase(at, length);
        bytes.insert(below(bytes.size() + 1), block);
        return note("moved a block from " + std::to_string(at));
      }
    }
  }

  void mutateText(std::string& text) {
    const Values values = valuesOf(text);
    switch (below(10)) {
      case 0:
      case 1:
      case 2:
        return replace(text, favoured(text, values.numbers, isIndex), number());
      case 3: {
        // Fits its place more often than a number from nowhere, and so is found out later.
        if (values.numbers.empty()) return mutateBytes(text);
        const std::vector<Span> some = favoured(text, values.numbers, isIndex);
        const Span one = some[below(some.size())];
        const Span other = below(2) == 0 ? one : values.numbers[below(values.numbers.size())];
        const std::string number = text.substr(other.begin, other.end - other.begin);
        return replace(text, {one}, below(3) == 0 ? number : neighbour(number));
      }
      case 4:
      case 5:
        return replace(text, favoured(text, values.strings, isFileName), string());
      case 6:
        return addMember(text, values);
      case 7:
        return swap(text, values.all);
      case 8: {
        if (values.all.empty()) return mutateBytes(text);
        const Span one = values.all[below(values.all.size())];
        const std::string value = text.substr(one.begin, one.end - one.begin);
        if (below(2) == 0) {
          text.insert(one.end, "," + value);
          return note("doubled a value at " + std::to_string(one.begin));
        }
        text.erase(one.begin, one.end - one.begin);
        return note("left out a value at " + std::to_string(one.begin));
      }
      default: {
        const std::size_t depth = std::size_t{1} << below(18);
        std::string nested;
        const bool isObject = below(2) == 0;
        for (std::size_t i = 0; i < depth; ++i)
          nested += isObject ? "{\"a\":" : "[";
        nested += "0" + std::string(depth, isObject ? '}' : ']');
        return replace(text, values.all, nested);
      }
    }
  }

 private:
  void note(const std::string& what) { what_ += (what_.empty() ? "" : ", ") + what; }

  /// Another member, before all others of an object.
  void addMember(std::string& text, const Values& values) {
    std::vector<Span> objects;
    std::copy_if(values.all.begin(), values.all.end(), std::back_inserter(objects),
                 [&](const Span& one) { return text[one.begin] == '{'; });
    if (objects.empty()) return mutateBytes(text);
    const std::size_t at = objects[below(objects.size())].begin + 1;
    const std::string member =
        below(2) == 0 ? "\"uri\":" + string() + "," : "\"byteOffset\":" + number() + ",";
    text.insert(at, member);
    note(member.substr(0, 60) + " at " + std::to_string(at));
  }

  /// Every second time those of one key, every key as often as any: there are thousands of coordinates, and
  /// each count is worth as much. Every fourth time those that more depends on.
  template <class IsFavoured>
  std::vector<Span> favoured(const std::string& text, const std::vector<Span>& values, IsFavoured is) {
    if (values.empty()) return values;
    const std::uint64_t way = below(4);
    std::vector<std::uint32_t> keys;
    if (way < 2) {
      for (const Span& one : values)
        if (one.key >= keys.size() || keys[one.key] == 0) {
          keys.resize(std::max<std::size_t>(keys.size(), one.key + 1));
          keys[one.key] = 1;
        }
    }
    const auto count = static_cast<std::uint64_t>(std::count(keys.begin(), keys.end(), 1U));
    std::uint64_t skip = below(count);
    const auto wanted =
        std::find_if(keys.begin(), keys.end(), [&](std::uint32_t k) { return k != 0 && skip-- == 0; });
    const auto key = static_cast<std::uint32_t>(wanted - keys.begin());
    std::vector<Span> some;
    std::copy_if(values.begin(), values.end(), std::back_inserter(some), [&](const Span& one) {
      return way < 2    ? one.key == key
             : way == 2 ? is(std::string_view(text).substr(one.begin, one.end - one.begin))
                        : true;
    });
    return some.empty() ? values : some;
  }

  /// A number near one that is there.
  std::string neighbour(const std::string& of) {
    const double value = std::strtod(of.c_str(), nullptr);
    if (!(std::abs(value) < 1e15)) return "0";
    const auto whole = static_cast<long long>(value);
    switch (below(4)) {
      case 0:
        return std::to_string(whole + 1);
      case 1:
        return std::to_string(whole - 1);
      case 2:
        return std::to_string(whole * 2);
      default:
        return std::to_string(whole + static_cast<long long>(below(1000)));
    }
  }

  std::string number() {
    static const std::vector<std::string> kNumbers = {
        "-1",    "0",      "1",     "2147483648", "4294967295", "4294967296", "18446744073709551616",
        "1e308", "-1e308", "1e39",  "1e999",      "NaN",        "-nan",       "Infinity",
        "0.5",   "5126",   "65536", "1e-320",     "null",       "true",       "\"text\"",
        "[]",    "{}",     "-0"};
    return kNumbers[below(kNumbers.size())];
  }

  std::string string() {
    switch (below(9)) {
      case 0:
        return "\"../../../../../../etc/passwd\"";
      case 1:
        return "\"" + bait_.url + "\"";
      case 2:
        return "\"data:application/octet-stream;base64,AAAA\"";
      case 3:
        return "\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAA//8AAP//CAYAAAA=\"";
      case 4:
        return "\"\"";
      case 5:
        return "\"" + std::string(std::size_t{1} << below(17), 'A') + "\"";
      case 6:
        return "\"\\u0000%00%2e%2e%2f\"";
      default:
        return bait_.paths.empty() ? "\"x\"" : "\"" + bait_.paths[below(bait_.paths.size())] + "\"";
    }
  }

  void replace(std::string& text, const std::vector<Span>& values, const std::string& by) {
    if (values.empty()) return mutateBytes(text);
    const Span one = values[below(values.size())];
    note("\"" + text.substr(one.begin, std::min<std::size_t>(one.end - one.begin, 30)) + "\" at " +
         std::to_string(one.begin) + " by " + by.substr(0, 60));
    text.replace(one.begin, one.end - one.begin, by);
  }

  /// Two values of one container change places.
  void swap(std::string& text, const std::vector<Span>& values) {
    if (values.size() < 2) return mutateBytes(text);
    for (int tries = 0; tries < 50; ++tries) {
      Span a = values[below(values.size())];
      std::vector<Span> siblings;
      for (const Span& other : values) {
        if (other.parent == a.parent && other.begin != a.begin) siblings.push_back(other);
      }
      if (siblings.empty()) continue;
      Span b = siblings[below(siblings.size())];
      if (b.begin < a.begin) std::swap(a, b);
      if (b.begin < a.end) continue;
      const std::string second = text.substr(b.begin, b.end - b.begin);
      text.replace(b.begin, b.end - b.begin, text, a.begin, a.end - a.begin);
      text.replace(a.begin, a.end - a.begin, second);
      return note("swapped values at " + std::to_string(a.begin) + " and " + std::to_string(b.begin));
    }
    mutateBytes(text);
  }

  std::mt19937_64 random_;
  const Bait& bait_;
  std::string what_;
};

std::uint32_t wordAt(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

void setWord(std::string& bytes, std::size_t at, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  std::memcpy(bytes.data() + at, &word, sizeof word);
}

/// Mutates the JSON of a GLB and makes the lengths around it fit.
void mutateGlbJson(std::string& bytes, Mutator& mutator) {
  constexpr std::size_t kJson = kGlbHeader + kChunkHeader;
  if (bytes.size() < kJson || wordAt(bytes, kGlbHeader) > bytes.size() - kJson)
    return mutator.mutateBytes(bytes);
  const std::size_t length = wordAt(bytes, kGlbHeader);
  std::string json = bytes.substr(kJson, length);
  mutator.mutateText(json);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  bytes.replace(kJson, length, json);
  setWord(bytes, kGlbHeader, json.size());
  setWord(bytes, 8, bytes.size());
}

}  // namespace

Mutant mutateScene(const std::string& bytes, const std::string& extension, std::uint64_t seed,
                   const Bait& bait) {
  Mutator mutator(seed, bait);
  Mutant mutant{bytes, {}};
  const std::uint64_t count = mutator.below(4) == 0 ? 2 + mutator.below(4) : 1;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (mutator.below(3) == 0) {
      mutator.mutateBytes(mutant.bytes);
    } else if (extension == ".glb") {
      mutateGlbJson(mutant.bytes, mutator);
    } else {
      mutator.mutateText(mutant.bytes);
    }
  }
  mutant.what = mutator.what();
  return mutant;
}

}  // namespace tessera::test

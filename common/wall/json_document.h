#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace tessera {

enum class JsonKind : std::uint8_t { Null, Boolean, Number, String, Array, Object };

class JsonDocument;

/// One value of a JsonDocument and the line it stands on. A cheap view: valid while the document lives and
/// stays where it is.
class JsonValue {
 public:
  [[nodiscard]] JsonKind kind() const;
  /// Where the value begins; counted from 1.
  [[nodiscard]] int line() const;
  /// Where its key stands; the value's line outside objects.
  [[nodiscard]] int keyLine() const;
  /// Its key in the object around it; empty outside objects.
  [[nodiscard]] std::string_view key() const;
  /// A finite number; 0 for other kinds.
  [[nodiscard]] double number() const;
  /// The truth value "true"; false for other kinds.
  [[nodiscard]] bool isTrue() const;
  /// UTF-8, may hold any character but NUL; empty for other kinds.
  [[nodiscard]] std::string_view string() const;
  /// Elements of an array, members of an object, in the order of the file.
  [[nodiscard]] std::vector<JsonValue> children() const;
  [[nodiscard]] std::optional<JsonValue> find(std::string_view key) const;

 private:
  friend class JsonDocument;
  JsonValue(const JsonDocument& document, std::size_t index) : document_(&document), index_(index) {}

  const JsonDocument* document_;
  std::size_t index_;
};

/// A JSON file (RFC 8259) in which // and /* */ comments and a UTF-8 byte order mark are allowed and keys
/// are unique, with the line of every value. Values lie flat in document order, so that a hostile file costs
/// memory in proportion to kMaxValues and no stack.
class JsonDocument {
 public:
  static constexpr int kMaxDepth = 64;
  static constexpr std::size_t kMaxValues = std::size_t{4} << 20;

  /// `text` below 4 GiB; `sourceName` stands for the file in the error.
  [[nodiscard]] static Result<JsonDocument> parse(std::string_view text, const std::string& sourceName);

  [[nodiscard]] JsonValue root() const { return {*this, 0}; }

 private:
  friend class JsonValue;
  friend class JsonBuilder;

  struct Slice {
    std::uint32_t offset = 0, size = 0;
  };
  struct Node {
    JsonKind kind = JsonKind::Null;
    int line = 0, keyLine = 0;
    std::uint32_t end = 0;  ///< index behind the last node of this value
    Slice key;
    double number = 0;  ///< of a truth value: 1 or 0
    Slice string;
  };

  [[nodiscard]] std::string_view view(Slice slice) const {
    return std::string_view(strings_).substr(slice.offset, slice.size);
  }

  std::vector<Node> nodes_;
  std::string strings_;
};

/// At most about `longestBytes` of UTF-8 text from a file, for a message; "..." stands for the rest.
[[nodiscard]] std::string excerpt(std::string_view text, std::size_t longestBytes);

}  // namespace tessera

#include "common/wall/json_document.h"

#include <algorithm>
#include <iterator>
#include <unordered_map>

#include <nlohmann/json.hpp>

namespace tessera {

namespace {

/// Walks the text for the parser and tells where the parser has come to. nlohmann's reader keeps copies of
/// its iterator, hence the place outside.
class TrackingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  TrackingIterator(const char* at, const char** consumed) : at_(at), consumed_(consumed) {}
  reference operator*() const { return *at_; }
  TrackingIterator& operator++() {
    *consumed_ = ++at_;
    return *this;
  }
  bool operator==(const TrackingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const TrackingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** consumed_;
};

/// "[json.exception.parse_error.101] parse error at line 2, column 3: syntax error ..." without its
/// beginning: the line is told elsewhere.
std::string plainMessage(std::string_view message) {
  if (message.starts_with('[')) message.remove_prefix(std::min(message.find("] ") + 2, message.size()));
  if (message.starts_with("parse error")) {
    message.remove_prefix(std::min(message.find(": ") + 2, message.size()));
  }
  return excerpt(message, 300);
}

}  // namespace

/// Receives the parser's events. An event comes as soon as its token has been read, and of the text behind
/// the token at most one character (the one that ends a number) has been read by then: so the line of the
/// last character read is the token's line.
class JsonBuilder {
 public:
  JsonBuilder(std::string_view text, std::string sourceName)
      : begin_(text.data()),
        end_(text.data() + text.size()),
        consumed_(begin_),
        counted_(begin_),
        source_(std::move(sourceName)) {}

  [[nodiscard]] Result<JsonDocument> run() {
    nlohmann::json::sax_parse(TrackingIterator(begin_, &consumed_), TrackingIterator(end_, &consumed_), this,
                              nlohmann::json::input_format_t::json, /*strict=*/true,
                              /*ignore_comments=*/true);
    if (error_) return *error_;
    return std::move(document_);
  }

  // The names that follow are nlohmann's SAX interface.
  bool null() { return add(JsonKind::Null); }
  bool boolean(bool value) { return add(JsonKind::Boolean, value ? 1 : 0); }
  bool number_integer(std::int64_t value) { return add(JsonKind::Number, static_cast<double>(value)); }
  bool number_unsigned(std::uint64_t value) { return add(JsonKind::Number, static_cast<double>(value)); }
  bool number_float(double value, const std::string& /*text*/) { return add(JsonKind::Number, value); }
  bool binary(const std::vector<std::uint8_t>& /*bytes*/) { return false; }
  bool string(const std::string& value) {
    if (!add(JsonKind::String)) return false;
    document_.nodes_.back().string = store(value);
    return true;
  }
  bool start_object(std::size_t /*size*/) { return open(JsonKind::Object); }
  bool start_array(std::size_t /*size*/) { return open(JsonKind::Array); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(const std::string& value) {
    const int line = lineNow();
    const auto [first, isNew] = open_.back().keys.emplace(value, line);
    if (!isNew) {
      return fail(line,
                  "the key \"" + excerpt(value, 64) + "\" stands twice in one object, first on line " +
                      std::to_string(first->second),
                  "remove one of them");
    }
    key_ = store(value);
    keyLine_ = line;
    return true;
  }
  bool parse_error(std::size_t /*position*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& error) {
    return fail(lineNow(), plainMessage(error.what()));
  }

 private:
  struct Open {
    std::size_t index;
    std::unordered_map<std::string, int> keys;  ///< and their lines
  };

  bool add(JsonKind kind, double number = 0) {
    if (document_.nodes_.size() >= JsonDocument::kMaxValues) {
      return fail(lineNow(), "more than " + std::to_string(JsonDocument::kMaxValues) + " values",
                  "is it the right file?");
    }
    JsonDocument::Node node;
    node.kind = kind;
    node.line = lineNow();
    node.keyLine = keyLine_ != 0 ? keyLine_ : node.line;
    node.key = key_;
    node.number = number;
    node.end = static_cast<std::uint32_t>(document_.nodes_.size() + 1);
    document_.nodes_.push_back(node);
    key_ = {};
    keyLine_ = 0;
    return true;
  }

  bool open(JsonKind kind) {
    if (open_.size() >= static_cast<std::size_t>(JsonDocument::kMaxDepth)) {
      return fail(lineNow(),
                  "brackets nested deeper than " + std::to_string(JsonDocument::kMaxDepth) + " levels",
                  "is it the right file?");
    }
    if (!add(kind)) return false;
    open_.push_back({document_.nodes_.size() - 1, {}});
    return true;
  }

  bool close() {
    document_.nodes_[open_.back().index].end = static_cast<std::uint32_t>(document_.nodes_.size());
    open_.pop_back();
    return true;
  }

  JsonDocument::Slice store(const std::string& value) {
    const auto offset = static_cast<std::uint32_t>(document_.strings_.size());
    document_.strings_ += value;
    return {offset, static_cast<std::uint32_t>(value.size())};
  }

  bool fail(int line, std::string what, std::string mend = {}) {
    error_ = inputError(source_ + ":" + std::to_string(line), std::move(what), std::move(mend));
    return false;
  }

  /// The line of the last character read. Never goes back, so the text is counted through once.
  int lineNow() {
    const char* last = std::max(counted_, consumed_ - 1);
    line_ += static_cast<int>(std::count(counted_, last, '\n'));
    counted_ = last;
    return line_;
  }

  const char* begin_;
  const char* end_;
  const char* consumed_;  ///< behind the last character that the parser has read
  const char* counted_;
  int line_ = 1;
  std::string source_;
  JsonDocument document_;
  std::vector<Open> open_;
  JsonDocument::Slice key_;
  int keyLine_ = 0;
  std::optional<Error> error_;
};

std::string excerpt(std::string_view text, std::size_t longestBytes) {
  if (text.size() <= longestBytes) return std::string(text);
  const auto isContinuation = [&](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80;
  };
  std::size_t end = longestBytes;
  while (end > 0 && isContinuation(end))
    --end;
  return std::string(text.substr(0, end)) + "...";
}

Result<JsonDocument> JsonDocument::parse(std::string_view text, const std::string& sourceName) {
  const auto failAt = [&](std::size_t offset, std::string what, std::string mend) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(offset);
    const auto line = 1 + std::count(text.begin(), end, '\n');
    return inputError(sourceName + ":" + std::to_string(line), std::move(what), std::move(mend));
  };
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    return failAt(0, "the file is empty", "write a JSON object, as the shipped configs do");
  }
  // nlohmann's lexer takes NUL for the end of the text and would ignore whatever follows.
  const std::size_t nul = text.find('\0');
  if (nul != std::string_view::npos) {
    return failAt(nul, "the text holds a NUL byte", "save the file as UTF-8 text");
  }
  return JsonBuilder(text, sourceName).run();
}

JsonKind JsonValue::kind() const {
  return document_->nodes_[index_].kind;
}
int JsonValue::line() const {
  return document_->nodes_[index_].line;
}
int JsonValue::keyLine() const {
  return document_->nodes_[index_].keyLine;
}
std::string_view JsonValue::key() const {
  return document_->view(document_->nodes_[index_].key);
}
double JsonValue::number() const {
  return kind() == JsonKind::Number ? document_->nodes_[index_].number : 0;
}
bool JsonValue::isTrue() const {
  return kind() == JsonKind::Boolean && document_->nodes_[index_].number != 0;
}
std::string_view JsonValue::string() const {
  return document_->view(document_->nodes_[index_].string);
}

std::vector<JsonValue> JsonValue::children() const {
  std::vector<JsonValue> found;
  const std::size_t end = document_->nodes_[index_].end;
  for (std::size_t i = index_ + 1; i < end; i = document_->nodes_[i].end) {
    found.push_back(JsonValue(*document_, i));
  }
  return found;
}

std::optional<JsonValue> JsonValue::find(std::string_view key) const {
  if (kind() != JsonKind::Object) return std::nullopt;
  const std::size_t end = document_->nodes_[index_].end;
  for (std::size_t i = index_ + 1; i < end; i = document_->nodes_[i].end) {
    if (document_->view(document_->nodes_[i].key) == key) return JsonValue(*document_, i);
  }
  return std::nullopt;
}

}  // namespace tessera

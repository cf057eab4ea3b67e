#include "common/wall/import/equalizer_tree.h"

#include <charconv>
#include <cmath>
#include <optional>

#include "common/wall/json_document.h"

namespace tessera {

namespace {

struct Token {
  enum class Kind : std::uint8_t { End, Word, Text, Number, Sign };
  Kind kind = Kind::End;
  std::string text;
  double number = 0;
  int line = 0;
};

bool isWordCharacter(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' ||
         c == '-' || c == '+';
}

class Parser {
 public:
  Parser(std::string_view text, std::string source) : text_(text), source_(std::move(source)) {}

  Result<EqualizerNode> run() {
    EqualizerNode root;
    next();
    block(root, 0);
    if (error_) return *error_;
    return root;
  }

 private:
  static constexpr int kMaxDepth = 32;
  static constexpr std::size_t kMaxListItems = 64;

  void fail(int line, std::string what, std::string mend = {}) {
    if (!error_) error_ = inputError(source_ + ':' + std::to_string(line), std::move(what), std::move(mend));
    token_ = Token{};
    token_.line = line;
    at_ = text_.size();
  }

  bool isSign(char sign) const { return token_.kind == Token::Kind::Sign && token_.text[0] == sign; }

  /// Reads the next token; the end of the text comes again and again.
  void next() {
    token_ = Token{};
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') ++line_;
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n')
          ++at_;
      } else if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
        ++at_;
      } else {
        break;
      }
    }
    token_.line = line_;
    if (at_ >= text_.size()) return;
    const char c = text_[at_];
    if (std::string_view("{}[]()").find(c) != std::string_view::npos) {
      token_.kind = Token::Kind::Sign;
      token_.text = c;
      ++at_;
    } else if (c == '"') {
      quoted();
    } else if (isWordCharacter(c)) {
      word();
    } else {
      fail(line_, "the character with the code " + std::to_string(static_cast<unsigned char>(c)) +
                      " has no meaning here");
    }
  }

  void quoted() {
    const std::size_t begin = ++at_;
    while (at_ < text_.size() && text_[at_] != '"' && text_[at_] != '\n')
      ++at_;
    if (at_ >= text_.size() || text_[at_] != '"') {
      fail(line_, "the quotes are not closed on their line", "add a \"");
      return;
    }
    token_.kind = Token::Kind::Text;
    token_.text = std::string(text_.substr(begin, at_ - begin));
    ++at_;
  }

  void word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && isWordCharacter(text_[at_]))
      ++at_;
    const std::string_view word = text_.substr(begin, at_ - begin);
    token_.text = std::string(word);
    token_.kind = Token::Kind::Word;
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (end != digits.data() + digits.size() || digits.empty()) return;
    if (error != std::errc{} || !std::isfinite(number)) {
      fail(line_, excerpt(word, 32) + " is no number that can be used");
      return;
    }
    token_.kind = Token::Kind::Number;
    token_.number = number;
  }

  /// The statements up to the brace that closes the block, or to the end of the text at depth 0.
  void block(EqualizerNode& node, int depth) {
    while (!error_) {
      if (token_.kind == Token::Kind::End) {
        if (depth > 0) {
          fail(token_.line,
               "the block \"" + excerpt(node.key, 64) + "\" that begins on line " +
                   std::to_string(node.line) + " is not closed",
               "add a }");
        }
        return;
      }
      if (isSign('}')) {
        if (depth == 0) fail(token_.line, "a } closes nothing");
        return;
      }
      if (token_.kind != Token::Kind::Word) {
        fail(token_.line,
             "\"" + excerpt(token_.text, 32) + "\" stands where the name of a setting must stand");
        return;
      }
      EqualizerNode child;
      child.key = token_.text;
      child.line = token_.line;
      next();
      value(child, depth);
      node.children.push_back(std::move(child));
    }
  }

  void value(EqualizerNode& node, int depth) {
    if (error_) return;
    if (isSign('{')) {
      if (depth >= kMaxDepth) {
        fail(token_.line, "blocks nested deeper than " + std::to_string(kMaxDepth) + " levels",
             "is it the right file?");
        return;
      }
      next();
      block(node, depth + 1);
      if (!error_) next();
    } else if (isSign('[') || isSign('(')) {
      list(node, isSign('[') ? ']' : ')');
    } else if (token_.kind == Token::Kind::Sign || token_.kind == Token::Kind::End) {
      fail(token_.line, "\"" + excerpt(node.key, 64) + "\" has no value");
    } else {
      node.kind = token_.kind == Token::Kind::Text     ? EqualizerNode::Kind::Text
                  : token_.kind == Token::Kind::Number ? EqualizerNode::Kind::Number
                                                       : EqualizerNode::Kind::Word;
      node.text = token_.text;
      node.number = token_.number;
      next();
    }
  }

  void list(EqualizerNode& node, char closing) {
    node.kind = EqualizerNode::Kind::List;
    for (next(); !error_ && !isSign(closing); next()) {
      if (token_.kind == Token::Kind::Sign || token_.kind == Token::Kind::End) {
        fail(node.line,
             std::string("the list of \"") + excerpt(node.key, 64) + "\" is not closed with " + closing);
      } else if (node.numbers.size() + node.words.size() >= kMaxListItems) {
        fail(node.line, "the list of \"" + excerpt(node.key, 64) + "\" has more than " +
                            std::to_string(kMaxListItems) + " items");
      } else if (token_.kind == Token::Kind::Number) {
        node.numbers.push_back(token_.number);
      } else {
        node.words.push_back(token_.text);
      }
    }
    if (!error_) next();
  }

  std::string_view text_;
  std::string source_;
  std::size_t at_ = 0;
  int line_ = 1;
  Token token_;
  std::optional<Error> error_;
};

}  // namespace

const EqualizerNode* EqualizerNode::find(std::string_view childKey) const {
  for (std::size_t i = children.size(); i > 0; --i) {
    if (children[i - 1].key == childKey) return &children[i - 1];
  }
  return nullptr;
}

Result<EqualizerNode> parseEqualizer(std::string_view text, const std::string& sourceName) {
  return Parser(text, sourceName).run();
}

}  // namespace tessera

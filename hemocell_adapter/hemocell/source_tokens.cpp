// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/source_tokens.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "hemocell_adapter/base/value.h"

namespace packmesh::hemocell {
namespace {

bool isLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (c & 0x80) != 0;
}
bool isDigit(char c) {
  return c >= '0' && c <= '9';
}
bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

bool isOpening(const Token& token) {
  return token.kind == Token::Kind::symbol && (token.is("(") || token.is("[") || token.is("{"));
}

class Lexer {
 public:
  explicit Lexer(const std::string& text) : text_(text) {}

  std::vector<Token> run() {
    while (at_ < text_.size()) next();
    endDirective();
    return std::move(tokens_);
  }

 private:
  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  bool starts(const char* with) const { return text_.compare(at_, std::strlen(with), with) == 0; }

  /// Advances by one character.
  void step() {
    if (text_[at_] == '\n') ++line_;
    ++at_;
  }
  /// Advances past the next `end`, or to the end of the text.
  void skipPast(const std::string& end) {
    const std::size_t found = text_.find(end, at_);
    const std::size_t to = found == text_.npos ? text_.size() : found + end.size();
    while (at_ < to) step();
  }

  void add(Token::Kind kind, std::string text, int line) {
    if (inDirective_)
      directive_.push_back({kind, std::move(text), line, 0});
    else if (!isDead())
      tokens_.push_back({kind, std::move(text), line, 0});
    atLineStart_ = false;
  }

  void next() {
    const char c = peek();
    if (c == '\n') {
      step();
      endDirective();
      atLineStart_ = true;
    } else if (isBlank(c)) {
      step();
    } else if (c == '\\' && (peek(1) == '\n' || (peek(1) == '\r' && peek(2) == '\n'))) {
      while (peek() != '\n') step();
      step();
    } else if (starts("//")) {
      lineComment();
    } else if (starts("/*")) {
      at_ += 2;
      skipPast("*/");
    } else if (c == '#' && atLineStart_) {
      step();
      inDirective_ = true;
    } else if (c == '"' || c == '\'') {
      quoted(c);
    } else if (isLetter(c)) {
      word();
    } else if (isDigit(c) || (c == '.' && isDigit(peek(1)))) {
      number();
    } else {
      symbol();
    }
  }

  /// Skips to the end of the line; a backslash continues the comment on the next line.
  void lineComment() {
    while (at_ < text_.size() && peek() != '\n') {
      if (peek() == '\\' && peek(1) == '\n') step();
      step();
    }
  }

  /// Reads a string or character literal; an unterminated one ends with its line.
  void quoted(char quote) {
    const int line = line_;
    step();
    std::string inside;
    while (at_ < text_.size() && peek() != quote && peek() != '\n') {
      if (peek() == '\\' && at_ + 1 < text_.size()) {
        inside += peek();
        step();
      }
      inside += peek();
      step();
    }
    if (peek() == quote) step();
    if (quote == '"')
      add(Token::Kind::string, inside, line);
    else
      add(Token::Kind::symbol, "'" + inside + "'", line);
  }

  void rawString() {
    const int line = line_;
    step();
    const std::size_t open = text_.find('(', at_);
    if (open == text_.npos) return;
    const std::string end = ")" + text_.substr(at_, open - at_) + "\"";
    at_ = open + 1;
    const std::size_t close = std::min(text_.find(end, at_), text_.size());
    add(Token::Kind::string, text_.substr(at_, close - at_), line);
    skipPast(end);
  }

  void word() {
    std::string letters;
    for (; isLetter(peek()) || isDigit(peek()); step()) letters += peek();
    if (peek() == '"') {
      for (const char* prefix : {"R", "LR", "uR", "UR", "u8R"})
        if (letters == prefix) return rawString();
      for (const char* prefix : {"L", "u", "U", "u8"})
        if (letters == prefix) return quoted('"');
    }
    add(Token::Kind::word, letters, line_);
  }

  void number() {
    std::string digits;
    while (isLetter(peek()) || isDigit(peek()) || peek() == '.' ||
           (peek() == '\'' && (isDigit(peek(1)) || isLetter(peek(1))))) {
      const char c = peek();
      if (c != '\'') digits += c;
      step();
      const bool exponent = std::strchr("eEpP", c) != nullptr;
      if (exponent && (peek() == '+' || peek() == '-')) {
        digits += peek();
        step();
      }
    }
    add(Token::Kind::number, digits, line_);
  }

  void symbol() {
    for (const char* two : {"->", "::", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=",
                            "|=", "^=", "==", "<=", ">=", "!=", "<<", ">>", "&&", "||"}) {
      if (!starts(two)) continue;
      at_ += 2;
      return add(Token::Kind::symbol, two, line_);
    }
    const char c = peek();
    step();
    add(Token::Kind::symbol, std::string(1, c), line_);
  }

  /// A branch of conditional compilation: `dead` if it is certainly excluded, `restDead` if all following
  /// branches certainly are.
  struct Branch {
    bool dead, restDead;
  };

  bool isDead() const {
    return std::any_of(branches_.begin(), branches_.end(), [](const Branch& b) { return b.dead; });
  }

  void endDirective() {
    if (!inDirective_) return;
    inDirective_ = false;
    const std::vector<Token> words = std::move(directive_);
    directive_.clear();
    if (words.empty()) return;
    const bool one = words.size() == 2;
    const bool never = one && (words[1].is("0") || words[1].is("false"));
    const bool always = one && (words[1].is("1") || words[1].is("true"));
    if (words[0].is("if")) {
      branches_.push_back({never, always});
    } else if (words[0].is("ifdef") || words[0].is("ifndef")) {
      branches_.push_back({false, false});
    } else if (branches_.empty()) {
      return;
    } else if (words[0].is("elif")) {
      Branch& branch = branches_.back();
      branch.dead = branch.restDead || never;
      branch.restDead = branch.restDead || always;
    } else if (words[0].is("else")) {
      branches_.back().dead = branches_.back().restDead;
    } else if (words[0].is("endif")) {
      branches_.pop_back();
    }
  }

  const std::string& text_;
  std::size_t at_ = 0;
  int line_ = 1;
  bool atLineStart_ = true, inDirective_ = false;
  std::vector<Token> tokens_, directive_;
  std::vector<Branch> branches_;
};

}  // namespace

std::vector<Token> tokensOf(const std::string& text) {
  std::vector<Token> tokens = Lexer(text).run();
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (isOpening(tokens[i])) {
      tokens[i].closing = tokens.size();
      open.push_back(i);
    } else if ((tokens[i].is(")") || tokens[i].is("]") || tokens[i].is("}")) && !open.empty()) {
      tokens[open.back()].closing = i;
      open.pop_back();
    }
  }
  return tokens;
}

std::vector<TokenRange> splitAtCommas(const std::vector<Token>& tokens, TokenRange range) {
  std::vector<TokenRange> parts;
  if (range.first == range.second) return parts;
  parts.emplace_back(range.first, range.second);
  for (std::size_t i = range.first; i < range.second; ++i) {
    if (isOpening(tokens[i])) {
      i = tokens[i].closing;
    } else if (tokens[i].is(",")) {
      parts.back().second = i;
      parts.emplace_back(i + 1, range.second);
    }
  }
  return parts;
}

bool isCall(const std::vector<Token>& tokens, std::size_t at) {
  if (at == 0) return false;
  const Token& before = tokens[at - 1];
  if (before.kind == Token::Kind::word)
    return before.is("else") || before.is("do") || before.is("return");  // otherwise a type
  if (before.is("*") || before.is("&") || before.is(">") || before.is("~")) return false;
  if (!before.is("::")) return true;
  const std::size_t close = tokens[at + 1].closing;  // a definition has a body
  return close + 1 < tokens.size() && !tokens[close + 1].is("{") && !tokens[close + 1].is("const");
}

std::string sourceText(const std::vector<Token>& tokens, TokenRange range) {
  std::string text;
  constexpr std::size_t longest = 120;
  for (std::size_t i = range.first; i < range.second && text.size() < longest; ++i) {
    const Token& t = tokens[i];
    const bool spaced =
        i > range.first &&
        (tokens[i - 1].is(",") || (t.kind != Token::Kind::symbol && tokens[i - 1].kind == Token::Kind::word));
    if (spaced) text += ' ';
    text += t.kind == Token::Kind::string ? "\"" + t.text + "\"" : t.text;
  }
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  if (text.size() <= longest) return text;
  std::size_t end = longest;
  while (end > 0 && (text[end] & 0xC0) == 0x80) --end;  // do not split a character
  return text.substr(0, end) + "...";
}

std::optional<std::string> literalString(const std::vector<Token>& tokens, TokenRange range) {
  std::string text;
  for (std::size_t i = range.first; i < range.second; ++i) {
    if (tokens[i].kind != Token::Kind::string) return {};
    text += tokens[i].text;
  }
  if (range.first == range.second) return {};
  return text;
}

std::optional<double> literalNumber(const std::vector<Token>& tokens, TokenRange range) {
  auto [first, last] = range;
  double sign = 1.0;
  if (first < last && (tokens[first].is("-") || tokens[first].is("+")))
    sign = tokens[first++].is("-") ? -1.0 : 1.0;
  if (last - first != 1 || tokens[first].kind != Token::Kind::number) return {};
  std::string digits = tokens[first].text;
  while (!digits.empty() && std::strchr("fFlLuU", digits.back())) digits.pop_back();
  const auto number = toNumber(digits);
  if (!number) return {};
  return sign * *number;
}

}  // namespace packmesh::hemocell

// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file C++ text as tokens, as far as finding calls with literal arguments needs it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

struct Token {
  enum class Kind { word, number, string, symbol } kind;
  std::string text;  ///< of a string: what stands between the quotes, escapes as they are written
  int line = 0;      ///< from 1 on
  /// Of an opening bracket ( [ {: index of the one that closes it, the number of tokens when there is none.
  std::size_t closing = 0;

  bool is(const char* symbolOrWord) const { return kind != Kind::string && text == symbolOrWord; }
};

/// The tokens of `text` without comments, preprocessor lines and what stands in `#if 0`. Text that is no C++
/// gives some tokens all the same.
std::vector<Token> tokensOf(const std::string& text);

using TokenRange = std::pair<std::size_t, std::size_t>;  ///< [first, last)

/// The parts of [first, last) between commas outside brackets; none when it is empty.
std::vector<TokenRange> splitAtCommas(const std::vector<Token>& tokens, TokenRange range);

/// Whether the word at `at`, which ( follows, is called there, not declared or defined.
bool isCall(const std::vector<Token>& tokens, std::size_t at);

/// The tokens as one line, cut when it is long, without control characters: for messages.
std::string sourceText(const std::vector<Token>& tokens, TokenRange range);

/// The contents of a string literal; nothing for anything else.
std::optional<std::string> literalString(const std::vector<Token>& tokens, TokenRange range);

/// The value of a decimal literal, with a sign or not; nothing for anything else.
std::optional<double> literalNumber(const std::vector<Token>& tokens, TokenRange range);

}  // namespace packmesh::hemocell

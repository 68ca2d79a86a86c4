// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tokeniser for C++ code, sufficient to find calls with literal arguments.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

struct Token {
  enum class Kind { word, number, string, symbol } kind;
  std::string text;  ///< of a string: the text between the quotes, with escapes unchanged
  int line = 0;      ///< line number, from 1
  /// Of an opening bracket ( [ {: index of the closing one, or the number of tokens if there is none.
  std::size_t closing = 0;

  bool is(const char* symbolOrWord) const { return kind != Kind::string && text == symbolOrWord; }
};

/// The tokens of `text` without comments, preprocessor lines and code in `#if 0`. Text that is not C++ also
/// gives tokens.
std::vector<Token> tokensOf(const std::string& text);

using TokenRange = std::pair<std::size_t, std::size_t>;  ///< [first, last)

/// The parts of [first, last) between commas outside brackets; none if the range is empty.
std::vector<TokenRange> splitAtCommas(const std::vector<Token>& tokens, TokenRange range);

/// True if the word at `at`, which is followed by (, is called there, not declared or defined.
bool isCall(const std::vector<Token>& tokens, std::size_t at);

/// The tokens as one line without control characters, truncated if long: for messages.
std::string sourceText(const std::vector<Token>& tokens, TokenRange range);

/// The contents of a string literal; empty for anything else.
std::optional<std::string> literalString(const std::vector<Token>& tokens, TokenRange range);

/// The value of a decimal literal with optional sign; empty for anything else.
std::optional<double> literalNumber(const std::vector<Token>& tokens, TokenRange range);

}  // namespace packmesh::hemocell

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/case_source.h"

#include <fmt/format.h>

#include <algorithm>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isSource(const fs::path& file) {
  const std::string ending = file.extension().string();
  for (const char* one : {".cpp", ".cc", ".cxx", ".C", ".h", ".hh", ".hpp", ".hxx"})
    if (ending == one) return true;
  return false;
}

/// Calls `found(index of the name, its arguments)` for each call of `name` with `arguments` arguments.
template <class Found>
void forCalls(const std::vector<Token>& tokens, const char* name, std::size_t arguments, Found&& found) {
  for (std::size_t i = 0; i + 1 < tokens.size(); ++i) {
    if (tokens[i].kind != Token::Kind::word || !tokens[i].is(name) || !tokens[i + 1].is("(")) continue;
    const std::size_t close = tokens[i + 1].closing;
    if (close == tokens.size() || !isCall(tokens, i)) continue;
    const std::vector<TokenRange> parts = splitAtCommas(tokens, {i + 2, close});
    if (parts.size() == arguments) found(TokenRange{i, close + 1}, parts);
  }
}

}  // namespace

void scanSource(const std::string& text, const std::string& file, CaseSource& source) {
  const std::vector<Token> tokens = tokensOf(text);
  source.files.push_back(file);
  forCalls(tokens, "setInitialMinimumDistanceFromSolid", 2,
           [&](TokenRange call, const std::vector<TokenRange>& arguments) {
             source.distances.push_back({fmt::format("{}:{}", file, tokens[call.first].line),
                                         sourceText(tokens, call), literalString(tokens, arguments[0]),
                                         literalNumber(tokens, arguments[1])});
           });
  forCalls(tokens, "setSystemPeriodicityLimit", 2, [&](TokenRange, const std::vector<TokenRange>& arguments) {
    source.periodicity.push_back({literalNumber(tokens, arguments[0]), literalNumber(tokens, arguments[1])});
  });
  for (PreInletCall& call : preInletCalls(tokens, file)) source.preInlets.push_back(std::move(call));
}

CaseSource readCaseSource(const fs::path& folder) {
  CaseSource source;
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (isSource(entry->path())) files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  constexpr std::uintmax_t largest = 1 << 20;  // [bytes]; handwritten files are smaller
  for (const fs::path& file : files) {
    std::error_code ignored;
    const std::string name = file.filename().string();
    if (fs::is_directory(file, ignored)) continue;
    if (fs::is_regular_file(file, ignored) && fs::file_size(file, ignored) > largest) {
      source.unread.push_back(fmt::format("{}: is larger than 1 MB and was not searched for calls", name));
      continue;
    }
    try {
      scanSource(contentOf(file, "a C++ file"), name, source);
    } catch (const InputError& failure) {
      source.unread.push_back(fmt::format("{}; it was not searched for calls", failure.what()));
    }
  }
  return source;
}

}  // namespace packmesh::hemocell

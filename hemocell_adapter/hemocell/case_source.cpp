// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/case_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "hemocell_adapter/base/plain_text.h"
#include "hemocell_adapter/base/value.h"
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

constexpr const char* blanks = " \t\r\n";

/// A text of the same length without comments, and one without the contents of literals, too.
struct Code {
  std::string withLiterals, bare;
};

Code codeOf(const std::string& text) {
  Code code{text, text};
  const std::size_t size = text.size();
  for (std::size_t at = 0; at < size;) {
    const std::size_t first = at;
    const auto past = [&](const char* end, std::size_t length) {
      const std::size_t found = text.find(end, first + 2);
      return found == text.npos ? size : found + length;
    };
    const char c = text[at];
    const bool separator = c == '\'' && at > 0 && text[at - 1] >= '0' && text[at - 1] <= '9';  // 1'000
    const bool comment = c == '/' && at + 1 < size && (text[at + 1] == '/' || text[at + 1] == '*');
    if (comment) {
      at = text[at + 1] == '/' ? past("\n", 0) : past("*/", 2);
    } else if ((c == '"' || c == '\'') && !separator) {
      // A literal that is not closed ends with its line.
      for (++at; at < size && text[at] != c && text[at] != '\n'; ++at)
        if (text[at] == '\\' && at + 1 < size) ++at;
    } else {
      ++at;
      continue;
    }
    for (std::size_t i = comment ? first : first + 1; i < at; ++i) {
      if (text[i] == '\n') continue;
      code.bare[i] = ' ';
      if (comment) code.withLiterals[i] = ' ';
    }
    if (!comment) at = std::min(at + 1, size);
  }
  return code;
}

/// A call of a member function.
struct Call {
  std::string where, text;
  std::vector<std::string> arguments;
};

/// `text` on one line, truncated if long: for messages.
std::string shortenedCode(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool blank = std::strchr(blanks, c) != nullptr;
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  constexpr std::size_t longest = 120;
  return plainText(line.size() > longest ? line.substr(0, longest) + "..." : line);
}

/// The call whose name is at [at, open), of a file; empty if its bracket at `open` is not closed soon.
std::optional<Call> callAt(const Code& code, std::size_t at, std::size_t open, const std::string& file) {
  constexpr std::size_t longest = 2000;  // [characters]
  Call call;
  std::size_t first = open + 1, depth = 0;
  for (std::size_t i = first; i < std::min(code.bare.size(), open + longest); ++i) {
    const char c = code.bare[i];
    const bool closes = c == ')' || c == ']' || c == '}';
    if (depth == 0 && (c == ',' || closes)) {
      call.arguments.push_back(trimmed(code.withLiterals.substr(first, i - first)));
      first = i + 1;
    }
    if (depth == 0 && closes) {
      if (c != ')') return {};
      const auto line = 1 + std::count(code.bare.begin(), code.bare.begin() + std::ptrdiff_t(at), '\n');
      call.where = fmt::format("{}:{}", file, line);
      call.text = shortenedCode(code.withLiterals.substr(at, i + 1 - at));
      return call;
    }
    if (c == '(' || c == '[' || c == '{') ++depth;
    if (closes) --depth;
  }
  return {};
}

/// The calls of a member function, or of one that is none, with this number of arguments; 0: any.
std::vector<Call> callsOf(const std::string& name, std::size_t arguments, const Code& code,
                          const std::string& file, bool ofMember = true) {
  std::vector<Call> calls;
  for (std::size_t at = code.bare.find(name); at != code.bare.npos; at = code.bare.find(name, at + 1)) {
    const std::size_t open = code.bare.find_first_not_of(blanks, at + name.size());
    const std::size_t before = at > 0 ? code.bare.find_last_not_of(blanks, at - 1) : code.bare.npos;
    if (open == code.bare.npos || code.bare[open] != '(' || before == code.bare.npos) continue;
    const bool arrow = before > 0 && code.bare.compare(before - 1, 2, "->") == 0;
    const char last = code.bare[at - 1];
    const bool isPartOfName = std::isalnum(static_cast<unsigned char>(last)) || last == '_';
    if (isPartOfName || ofMember != (code.bare[before] == '.' || arrow)) continue;
    std::optional<Call> call = callAt(code, at, open, file);
    if (call && (arguments == 0 || call->arguments.size() == arguments)) calls.push_back(std::move(*call));
  }
  return calls;
}

/// The contents of a string literal without backslashes; empty for anything else.
std::optional<std::string> literalString(const std::string& argument) {
  if (argument.size() < 2 || argument.front() != '"' || argument.back() != '"') return {};
  std::string inside = argument.substr(1, argument.size() - 2);
  if (inside.find_first_of("\"\\") != inside.npos) return {};
  return inside;
}

/// The value of a decimal literal with optional sign and suffix; empty for anything else.
std::optional<double> literalNumber(std::string argument) {
  if (argument.find_first_of("0123456789") == argument.npos) return {};
  while (std::strchr("fFlLuU", argument.back())) argument.pop_back();
  return toNumber(argument);
}

/// The direction in `Direction::Xpos`.
std::optional<std::string> directionIn(const std::string& argument) {
  const std::size_t scope = argument.rfind("::");
  const std::string last = scope == argument.npos ? argument : argument.substr(scope + 2);
  for (const char* name : {"Xneg", "Xpos", "Yneg", "Ypos", "Zneg", "Zpos"})
    if (last == name) return last;
  return {};
}

}  // namespace

void scanSource(const std::string& text, const std::string& file, CaseSource& source) {
  const Code code = codeOf(text);
  source.files.push_back(file);
  for (const Call& call : callsOf("setInitialMinimumDistanceFromSolid", 2, code, file))
    source.distances.push_back(
        {call.where, call.text, literalString(call.arguments[0]), literalNumber(call.arguments[1])});
  for (const Call& call : callsOf("setSystemPeriodicityLimit", 2, code, file))
    source.periodicity.push_back({literalNumber(call.arguments[0]), literalNumber(call.arguments[1])});
  for (const Call& call : callsOf("setSystemPeriodicity", 2, code, file))
    if (call.arguments[1] != "false") {
      const auto axis = literalNumber(call.arguments[0]);
      const bool known = axis && (*axis == 0.0 || *axis == 1.0 || *axis == 2.0);
      source.periodicAxes.push_back(
          {call.where, call.text, known ? std::optional(int(*axis)) : std::nullopt});
    }
  for (const Call& call : callsOf("defineDynamics", 0, code, file, false))  // (lattice, box, dynamics)
    if (call.arguments.size() > 2 && call.arguments[2].find("BounceBack") != std::string::npos)
      source.walls.push_back({call.where, call.text});
  for (const Call& call : callsOf("preInletFromSlice", 2, code, file))
    source.preInlets.push_back({call.where, call.text, directionIn(call.arguments[0]), {}});
  for (const Call& call : callsOf("autoPreinletFromBoundary", 1, code, file)) {
    PreInletCall& inlet = source.preInlets.emplace_back();
    inlet = {call.where, call.text, directionIn(call.arguments[0]), {}};
    // HemoCell takes the last plane but one, or the second.
    if (inlet.direction) inlet.slice = (*inlet.direction)[1] == 'p' ? -2 : 1;
  }
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

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/state_words.h"

#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

constexpr const char* placeholder = "{folder}/";

/// The folder of a state with "/" at its end; in a `<packing>` section as XML writes it.
std::string folderOf(const std::filesystem::path& state, bool inSection) {
  const std::string folder =
      (std::filesystem::absolute(state).lexically_normal().parent_path() / "").string();
  if (!inSection) return folder;
  std::string escaped;
  for (const char c : folder) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (c == '\'')
      escaped += "&apos;";
    else
      escaped += c;
  }
  return escaped;
}

/// Replaces `from` where a path begins.
std::string replaced(const std::string& word, const std::string& from, const std::string& to) {
  std::string text;
  std::size_t done = 0;
  for (std::size_t at = word.find(from); at != std::string::npos; at = word.find(from, done)) {
    const bool begins = at == 0 || word[at - 1] == '=' || word[at - 1] == '"' || word[at - 1] == '\'';
    text += word.substr(done, at - done) + (begins ? to : from);
    done = at + from.size();
  }
  return text + word.substr(done);
}

}  // namespace

std::vector<std::string> storedWords(std::vector<std::string> words, const std::filesystem::path& state) {
  for (std::string& word : words)
    word = replaced(word, folderOf(state, word.rfind('<', 0) == 0), placeholder);
  return words;
}

std::vector<std::string> wordsNow(std::vector<std::string> words, const std::filesystem::path& state) {
  for (std::string& word : words)
    word = replaced(word, placeholder, folderOf(state, word.rfind('<', 0) == 0));
  return words;
}

bool isOfSimulation(const std::vector<std::string>& words) {
  return words.size() == 2 && words.back().rfind("iteration ", 0) == 0;
}

void requireCommand(const std::vector<std::string>& words, const std::filesystem::path& state) {
  if (!isOfSimulation(words)) return;
  throw InputError(
      state.string() +
      ": has the cells of a simulation, and no packing to continue: --start, --fixed and --blood take them");
}

}  // namespace packmesh::hemocell

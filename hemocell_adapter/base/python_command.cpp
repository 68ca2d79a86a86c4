// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/python_command.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "hemocell_adapter/base/messages.h"
#include "packMesh/core/process.h"

extern char** environ;

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

// Exit codes of packmesh (python/packmesh/files.py).
constexpr int refusedCode = 2, unusableCode = 69;

/// The environment without the variables by which launchers of MPI name ranks.
std::vector<std::string> environmentWithoutRanks() {
  std::vector<std::string> kept;
  for (char** variable = environ; *variable; ++variable) {
    const std::string_view text(*variable);
    bool ofRank = false;
    for (const std::string_view prefix : {"OMPI_", "PMIX_", "PMI_", "PRTE_", "SLURM_", "MPI_LOCALNRANKS"})
      ofRank = ofRank || text.substr(0, prefix.size()) == prefix;
    if (!ofRank) kept.emplace_back(text);
  }
  return kept;
}

/// Reads both until the child has closed them. @return false if `stop` ended it
bool readBoth(Descriptor& out, Descriptor& err, std::string& outText, std::string& errText, pid_t child,
              const std::function<bool()>& stop) {
  bool stopped = false;
  while (out.isOpen() || err.isOpen()) {
    std::array<pollfd, 2> ends = {{{out.number(), POLLIN, 0}, {err.number(), POLLIN, 0}}};
    ::poll(ends.data(), ends.size(), 100);
    if (!stopped && stop && stop()) {
      stopped = true;
      ::kill(child, SIGTERM);
    }
    const auto readSome = [](const pollfd& end, Descriptor& descriptor, std::string& text) {
      if (end.revents == 0) return;
      std::array<char, 4096> bytes;
      const ssize_t n = ::read(descriptor.number(), bytes.data(), bytes.size());
      if (n > 0)
        text.append(bytes.data(), static_cast<std::size_t>(n));
      else if (n == 0 || errno != EINTR)
        descriptor.close();
    };
    readSome(ends[0], out, outText);
    readSome(ends[1], err, errText);
  }
  return !stopped;
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The rest of a line that begins with `prefix`; nothing if it does not.
std::optional<std::string> after(const std::string& prefix, const std::string& line) {
  if (line.compare(0, prefix.size(), prefix) != 0) return {};
  return line.substr(prefix.size());
}

}  // namespace

std::vector<std::string> packmeshCommand() {
  std::error_code error;
  const fs::path beside = fs::read_symlink("/proc/self/exe", error).parent_path() / "packmesh";
  if (!error && isProgram(beside)) return {beside.string()};
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && isProgram(fs::path(folder) / "packmesh")) return {folder + "/packmesh"};
  return {"python3", "-m", "packmesh"};
}

CommandEnd runPackmesh(const std::vector<std::string>& arguments, const std::function<bool()>& stop) {
  std::vector<std::string> words = packmeshCommand();
  const bool asModule = words.size() > 1;
  words.insert(words.end(), arguments.begin(), arguments.end());
  Descriptor out, err, itsOut, itsErr;
  pid_t child = -1;
  int error = 0;
  if (makePipe(out, itsOut) && makePipe(err, itsErr))
    error = spawn({words, environmentWithoutRanks(), {-1, itsOut.number(), itsErr.number()}, {}}, child);
  else
    error = errno;
  itsOut.close();
  itsErr.close();
  using End = CommandEnd::Kind;
  if (error == ENOENT) return {End::unusable, {}, "is not installed"};
  if (error != 0)
    return {End::failed, {}, fmt::format("{} cannot be started: {}", words.front(), std::strerror(error))};
  std::string outText, errText;
  const bool stopped = !readBoth(out, err, outText, errText, child, stop);
  const int status = statusAtEnd(child).value_or(0);
  CommandEnd end;
  std::string rest;  // what Python itself says
  for (const std::string& line : linesOf(errText)) {
    if (const auto warning = after("(packMesh) (Warning) ", line))
      log::warning(*warning);
    else if (const auto failure = after("(packMesh) (Error) ", line))
      end.message = *failure;
    else if (!line.empty())
      rest = line;
  }
  for (const std::string& line : linesOf(outText))
    end.lines.push_back(after("(packMesh) ", line).value_or(line));
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (stopped)
    end.kind = End::stopped;
  else if (code == 0)
    end.kind = End::done;
  else if (code == unusableCode || (asModule && rest.find("No module named packmesh") != std::string::npos))
    end.kind = End::unusable;
  else
    end.kind = code == refusedCode && !end.message.empty() ? End::refused : End::failed;
  if (end.kind == End::unusable && end.message.empty()) end.message = "is not installed";
  if (end.message.empty())
    end.message = code < 0 ? fmt::format("{} was killed by signal {}", words.front(), WTERMSIG(status))
                           : fmt::format("{} ended with code {}: {}", words.front(), code, rest);
  return end;
}

std::string asTyped(const std::vector<std::string>& arguments) {
  std::string text = "packmesh";
  for (const std::string& word : arguments) {
    const bool plain = !word.empty() && word.find_first_not_of(
                                            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                            "0123456789_-./=,:+@%") == std::string::npos;
    std::string quoted;
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    text += plain ? " " + word : " '" + quoted + "'";
  }
  return text;
}

}  // namespace packmesh::hemocell

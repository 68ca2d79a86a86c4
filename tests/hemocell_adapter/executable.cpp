// SPDX-License-Identifier: AGPL-3.0-or-later
#include "tests/hemocell_adapter/executable.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <wordexp.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/messages.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"

namespace packmesh::test {
namespace {

namespace fs = std::filesystem;

/// What this process writes to a descriptor while the object lives.
class Captured {
 public:
  explicit Captured(int descriptor) : descriptor_(descriptor), file_(memfd_create("captured", MFD_CLOEXEC)) {
    flush();
    before_ = ::dup(descriptor);
    if (file_ < 0 || before_ < 0 || ::dup2(file_, descriptor) < 0)
      throw std::runtime_error("output cannot be captured");
  }
  ~Captured() {
    flush();
    ::dup2(before_, descriptor_);
    ::close(before_);
    ::close(file_);
  }
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;

  std::string text() const {
    flush();
    return readText("/proc/self/fd/" + std::to_string(file_));
  }

 private:
  static void flush() {
    std::cout.flush();
    std::fflush(nullptr);
  }
  int descriptor_, file_, before_ = -1;
};

/// The handlers of signals and the level of messages that the program changes, as they were before.
class Settings {
 public:
  Settings() {
    for (std::size_t i = 0; i < std::size(signals); ++i) sigaction(signals[i], nullptr, &before_[i]);
    hemocell::log::setLevel(hemocell::log::Level::normal);
  }
  ~Settings() {
    for (std::size_t i = 0; i < std::size(signals); ++i) sigaction(signals[i], &before_[i], nullptr);
    hemocell::log::setLevel(level_);
    fs::current_path(folder_);
  }
  Settings(const Settings&) = delete;
  Settings& operator=(const Settings&) = delete;

 private:
  static constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1, SIGXFSZ};
  struct sigaction before_[std::size(signals)];
  hemocell::log::Level level_ = hemocell::log::level();
  fs::path folder_ = fs::current_path();
};

std::vector<std::string> shellWords(const std::string& text) {
  wordexp_t words;
  if (wordexp(text.c_str(), &words, WRDE_NOCMD | WRDE_UNDEF) != 0)
    throw std::runtime_error("no words of a command line: " + text);
  const std::vector<std::string> all(words.we_wordv, words.we_wordv + words.we_wordc);
  wordfree(&words);
  return all;
}

}  // namespace

void writeText(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

nlohmann::json parseJson(const std::string& text) {
  return nlohmann::json::parse(text);
}

nlohmann::json readJson(const fs::path& file) {
  return parseJson(readText(file));
}

int cellsIn(const fs::path& file) {
  std::ifstream in(file);
  int n = -1;
  in >> n;
  return n;
}

Ran run(const Folder& folder, const std::string& arguments, const std::string& program) {
  const Settings settings;
  fs::current_path(folder);
  const std::vector<std::string> words = shellWords(arguments);
  const Captured out(STDOUT_FILENO), err(STDERR_FILENO);
  Ran ran;
  ran.exitCode = int(hemocell::runAndTell(program, words, Communicator()));
  ran.out = out.text();
  ran.err = err.text();
  return ran;
}

Ran withExit(int exitCode, Ran ran) {
  INFO(ran.all().substr(0, 10000));
  REQUIRE(ran.exitCode == exitCode);
  return ran;
}

Ran ended(const Folder& folder, int exitCode, const std::string& arguments, const std::string& program) {
  INFO(program << ' ' << arguments.substr(0, 1000));
  return withExit(exitCode, run(folder, arguments, program));
}

Ran ok(const Folder& folder, const std::string& arguments) {
  return ended(folder, 0, arguments);
}

Ran runProcess(const Folder& folder, const std::string& arguments, const std::string& prefix,
               const std::string& program) {
  const TemporaryFolder output;
  const std::string command = "cd '" + folder.string() + "' && " + awaitingAll() + " env " + prefix + " '" +
                              (fs::path(programFolder) / program).string() + "' " + arguments + " > '" +
                              (output.path() / "out").string() + "' 2> '" + (output.path() / "err").string() +
                              "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), readText(output.path() / "out"),
          readText(output.path() / "err")};
}

std::string awaitingAll() {
  return "'" + (fs::path(programFolder) / "await_all").string() + "'";
}

std::string onRanks(int ranks, int grace) {
  return "ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
         "OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1 "
         "PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe "
         "OMPI_MCA_odls_base_sigkill_timeout=" +
         std::to_string(grace) + " PRTE_MCA_odls_base_sigkill_timeout=" + std::to_string(grace) +
         " timeout " + std::to_string(timeout / 2) + " mpirun -n " + std::to_string(ranks);
}

}  // namespace packmesh::test

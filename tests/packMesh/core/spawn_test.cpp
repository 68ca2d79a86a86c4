// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/spawn.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>

using namespace packmesh;

namespace {

std::string allOf(const Descriptor& descriptor) {
  std::string text;
  char buffer[256];
  for (ssize_t n; (n = read(descriptor.number(), buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  return text;
}

/// What a command of the shell prints.
std::string printedBy(StartedProgram program) {
  Descriptor ours, theirs;
  REQUIRE(makePipe(ours, theirs));
  program.descriptors = {-1, theirs.number(), -1};
  pid_t id = -1;
  REQUIRE(spawn(program, id) == 0);
  theirs.close();
  const std::string text = allOf(ours);
  CHECK(statusAtEnd(id) == 0);
  return text;
}

}  // namespace

TEST_CASE("A descriptor is closed once, at the end of its scope or when another takes its place") {
  int first = -1, second = -1;
  const auto isOpen = [](int number) { return fcntl(number, F_GETFD) >= 0; };
  {
    Descriptor read, write;
    REQUIRE(makePipe(read, write));
    first = read.number(), second = write.number();
    CHECK(first >= leastOwnDescriptor);
    CHECK(second >= leastOwnDescriptor);
    CHECK((fcntl(first, F_GETFD) & FD_CLOEXEC) != 0);
    Descriptor moved = std::move(read);
    CHECK_FALSE(read.isOpen());
    CHECK(moved.number() == first);
    write = std::move(moved);
    CHECK_FALSE(isOpen(second));
    CHECK(isOpen(first));
  }
  CHECK_FALSE(isOpen(first));
}

TEST_CASE("A started program has the words, environment, files and signals that it is given, and no others") {
  CHECK(printedBy({{"/bin/sh", "-c", "echo \"$A,$1\"; env | grep -c ^HOME=; true", "sh", "b c"},
                   {"A=1", "PATH=/usr/bin:/bin"}}) == "1,b c\n0\n");
  CHECK(printedBy({{"sh", "-c", "cat; echo end"}, {"PATH=/usr/bin:/bin"}}) == "end\n");
  // Files: 0, 1, 2, and that of ls itself.
  Descriptor kept(open("/dev/null", O_RDONLY));
  REQUIRE(kept.isOpen());
#if __GLIBC_PREREQ(2, 34)
  CHECK(printedBy({{"ls", "/proc/self/fd"}, {}}) == "0\n1\n2\n3\n");
#endif
  StartedProgram blocking{{"grep", "SigBlk", "/proc/self/status"}, {}};
  blocking.blockedSignals = {SIGTERM};
  const std::string mask = printedBy(blocking);
  CHECK(std::stoull(mask.substr(mask.find(':') + 1), nullptr, 16) == 1u << (SIGTERM - 1));
}

TEST_CASE("A program that cannot be started is an error of the system") {
  pid_t id = -1;
  CHECK(spawn({{"/nonexistent/program"}, {}, {-1, -1, -1}}, id) == ENOENT);
  CHECK_FALSE(isProgram("/nonexistent/program"));
  CHECK_FALSE(isProgram("/etc/passwd"));
  CHECK_FALSE(isProgram("/bin"));
  CHECK(isProgram("/bin/sh"));
}

TEST_CASE("The status of a program that ended") {
  pid_t id = -1;
  REQUIRE(spawn({{"/bin/sh", "-c", "exit 7"}, {}, {-1, -1, -1}}, id) == 0);
  const std::optional<int> status = statusAtEnd(id);
  REQUIRE(status);
  CHECK(WEXITSTATUS(*status) == 7);
  CHECK_FALSE(statusAtEnd(id));
}

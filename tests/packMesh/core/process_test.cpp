// SPDX-License-Identifier: AGPL-3.0-or-later
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <thread>

#include "packMesh/core/process.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

namespace {

std::string allOf(const Descriptor& descriptor) {
  std::string text;
  char buffer[256];
  for (ssize_t n; (n = read(descriptor.number(), buffer, sizeof buffer)) > 0;)
    text.append(buffer, std::size_t(n));
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

namespace {

constexpr std::size_t enough = 100 << 20;

/// A shell script in place of a helper.
HelperProcess script(const std::string& text, const std::string& request = {}, std::size_t most = enough) {
  return HelperProcess("/bin/sh", {"-c", text}, request, most);
}

void await(HelperProcess& helper) {
  while (!helper.wait(1000)) continue;
}

std::string bytes(std::size_t count) {
  std::string out(count, '\0');
  for (std::size_t k = 0; k < count; ++k) out[k] = char(k * 2654435761u >> 13);
  return out;
}

}  // namespace

TEST_CASE("A helper gets a request of any size and returns an answer of any size", "[helper]") {
  for (const std::size_t size : {0, 1, 5'000'000}) {
    HelperProcess helper = script("cat <&3 >&3", bytes(size));
    await(helper);
    REQUIRE((helper.answer() == bytes(size)));
    REQUIRE(helper.fault().empty());
    REQUIRE(helper.words().empty());
  }
}

TEST_CASE("What happens to a helper is told", "[helper]") {
  const auto faultOf = [](HelperProcess helper) {
    await(helper);
    return helper.fault();
  };
  REQUIRE(faultOf(script("exit 3")) == "ended with exit code 3");
  REQUIRE(faultOf(script("kill -9 $$")) == "was ended by signal 9 (Killed)");
  REQUIRE(faultOf(script("kill -9 $$", bytes(5'000'000))) ==
          "was ended by signal 9 (Killed)");  // no SIGPIPE here
  REQUIRE(faultOf(script("cat /dev/zero >&3", {}, 100'000)) == "sent more than 100000 bytes");
  REQUIRE(faultOf(HelperProcess("/no/such/program", {}, {}, 1)) ==
          "cannot be started: No such file or directory");
  REQUIRE(faultOf(HelperProcess("/etc/passwd", {}, {}, 1)) == "cannot be started: Permission denied");
  HelperProcess talks = script("echo; echo one; echo '  two' >&2; echo; yes | head -c 1000000; exit 1");
  await(talks);
  REQUIRE(talks.words().substr(0, 11) == "one two y y");
  REQUIRE(talks.words().size() < 100'000);
  REQUIRE(talks.fault() == "ended with exit code 1");
}

TEST_CASE("A helper that closes its end is ended with all that it has started", "[helper]") {
  HelperProcess helper = script("exec 3>&-; sleep 1000 & sleep 1000");
  await(helper);
  REQUIRE(helper.fault() == "was ended by signal 9 (Killed)");
}

TEST_CASE("A helper ends when it is not wanted any more", "[helper]") {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "id").string();
  pid_t id = 0;
  {
    HelperProcess helper = script("echo $$ > '" + file + "'; exec sleep 100000");
    while (!(std::ifstream(file) >> id)) REQUIRE_FALSE(helper.wait(1));
    REQUIRE(kill(id, 0) == 0);
  }
  REQUIRE(kill(id, 0) != 0);
}

TEST_CASE("A helper inherits neither open files nor what MPI tells its ranks", "[helper]") {
  const int open = ::open("/dev/null", O_RDONLY);
  REQUIRE(open >= 0);
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID", "LD_PRELOAD"})
    setenv(name, "", 1);
  HelperProcess helper = script("ls /proc/$$/fd; env | grep -c 'MPI\\|PMI\\|SLURM\\|LD_PRE'");
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID", "LD_PRELOAD"})
    unsetenv(name);
  await(helper);
  close(open);
  REQUIRE(helper.words() == "0 1 2 3 0");
}

TEST_CASE("A helper does not react to signals that ask programs to stop, and is in a group of its own",
          "[helper]") {
  HelperProcess helper = script(
      "for s in INT TERM HUP QUIT XCPU USR1 USR2 ALRM; do kill -$s $$; done; "
      "test $(cut -d' ' -f5 /proc/$$/stat) = $$ && echo alive");
  await(helper);
  REQUIRE(helper.words() == "alive");
  REQUIRE(helper.fault().empty());
}

TEST_CASE("Many helpers run side by side, started by several threads", "[helper][threads]") {
  std::vector<std::thread> threads;
  std::array<int, 4> right{};
  for (std::size_t t = 0; t < right.size(); ++t)
    threads.emplace_back([&, t] {
      std::vector<std::unique_ptr<HelperProcess>> helpers;
      for (std::size_t k = 0; k < 8; ++k)
        helpers.push_back(std::make_unique<HelperProcess>(
            "/bin/sh", std::vector<std::string>{"-c", "cat <&3 >&3"}, bytes(100'000 + 10 * t + k), enough));
      for (std::size_t k = 0; k < helpers.size(); ++k) {
        await(*helpers[k]);
        right[t] += helpers[k]->answer() == bytes(100'000 + 10 * t + k);
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const int count : right) REQUIRE(count == 8);
}

TEST_CASE("A program without standard streams, or with SIGCHLD ignored, can have helpers", "[helper]") {
  const auto before = signal(SIGCHLD, SIG_IGN);
  const int saved = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 10);
  close(STDIN_FILENO);
  HelperProcess helper = script("cat <&3 >&3; echo word", "request");
  await(helper);
  dup2(saved, STDIN_FILENO);
  close(saved);
  signal(SIGCHLD, before);
  REQUIRE(helper.answer() == "request");
  REQUIRE(helper.words() == "word");
}

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run_lock.h"

#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "packMesh/core/temporary_name.h"
#include "tests/hemocell_adapter/executable.h"

using namespace packmesh::hemocell;
using namespace packmesh::test;
using Catch::Matchers::Contains;
using packmesh::temporaryName;
using packmesh::hemocell::ExitCode;
namespace fs = std::filesystem;

namespace {

const std::string small = "20 20 20 --rbc 3";

}  // namespace

TEST_CASE("A second run in the same folder is rejected and names the first", "[executable]") {
  const TemporaryFolder folder;
  {
    const RunLock held = RunLock::ofFolder(folder.path());
    for (const std::string more : {"", " --realisations 2"}) {
      const Ran second = run(folder.path(), small + more);
      INFO(second.all());
      CHECK(second.exitCode == int(ExitCode::cannotWrite));
      CHECK_THAT(second.err, Contains("another packMesh is writing into this folder (process " +
                                      std::to_string(getpid()) + " on "));
      CHECK_THAT(second.err, Contains("--output-dir"));
    }
    CHECK(folder.files() == 1);
    CHECK(run(folder.path(), small + " --validate").exitCode == 0);
    CHECK(run(folder.path(), small + " --dry-run").exitCode == 0);
    CHECK(run(folder.path(), small + " --output-dir other").exitCode == 0);
    CHECK(run(folder.path() / "other", "check --box 20 20 20").exitCode == 0);
    fs::copy_file(folder.path() / "other/RBC.pos", folder.path() / "RBC.pos");
    CHECK(run(folder.path(), "check --box 20 20 20").exitCode == 0);
    CHECK_THROWS_AS(RunLock::ofFolder(folder.path()), packmesh::OutputError);
  }
  CHECK(run(folder.path(), small).exitCode == 0);
  CHECK(folder.files() == 2);  // RBC.pos, other
}

TEST_CASE("A second run with the same state is rejected in any folder", "[executable]") {
  const TemporaryFolder folder;
  {
    const RunLock held = RunLock::ofFile(folder.path() / "s.h5");
    const Ran second = run(folder.path(), small + " --output-dir other --state s.h5");
    INFO(second.all());
    CHECK(second.exitCode == int(ExitCode::cannotWrite));
    CHECK_THAT(second.err, Contains("s.h5: another packMesh is writing it (process "));
    CHECK(folder.files() == 1);  // the folder that stayed empty is gone
  }
  // What a killed run left of a state goes away; what other states have left stays, or is being written.
  const auto temporary = [&](const char* state) { return temporaryName(folder.path() / state, 0, "new"); };
  for (const char* state : {"s", "s.h5", "t.h5"}) writeText(temporary(state), "half");
  CHECK(run(folder.path(), small + " --state s").exitCode == 0);
  CHECK_FALSE(fs::exists(temporary("s")));
  CHECK(fs::exists(temporary("s.h5")));
  CHECK(run(folder.path(), small + " --state s.h5").exitCode == 0);
  CHECK_FALSE(fs::exists(temporary("s.h5")));
  CHECK(fs::exists(temporary("t.h5")));
  CHECK(folder.files() == 4);  // RBC.pos, s, s.h5, what is left of t.h5
}

TEST_CASE("A lock ends with its process, however the process ends", "[executable]") {
  const TemporaryFolder folder;
  int ready[2];
  REQUIRE(pipe(ready) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const RunLock held = RunLock::ofFolder(folder.path());
    [[maybe_unused]] const ssize_t told = write(ready[1], "!", 1);
    for (;;) pause();
  }
  char taken = 0;
  REQUIRE(read(ready[0], &taken, 1) == 1);
  CHECK(run(folder.path(), small).exitCode == int(ExitCode::cannotWrite));
  // What it was writing: the name has its number.
  const std::string own = std::to_string(getpid());
  std::string left = temporaryName(folder.path() / "RBC.pos", 0, "new").filename().string();
  left.replace(left.rfind(own + "-"), own.size(), std::to_string(child));
  writeText(folder.path() / left, "half");
  const auto other = temporaryName(folder.path() / "report.json", 0, "new");  // of a process that lives
  writeText(other, "half");
  kill(child, SIGKILL);
  REQUIRE(waitpid(child, nullptr, 0) == child);
  close(ready[0]);
  close(ready[1]);
  CHECK(fs::exists(folder.path() / ".packMesh.lock"));
  CHECK(run(folder.path(), small).exitCode == 0);
  CHECK_FALSE(fs::exists(folder.path() / left));
  CHECK(fs::exists(other));
  CHECK(folder.files() == 2);  // RBC.pos as well
}

TEST_CASE("A folder created by a run that wrote nothing is removed") {
  const TemporaryFolder folder;
  const Ran ran = run(folder.path(),
                      "15 15 15 --hematocrit 0.7 --max-iterations 20 --output-dir new/deep --state new/s.h5");
  INFO(ran.all());
  REQUIRE(ran.exitCode == int(ExitCode::outOfReach));
  // The state of what was not reached is kept, to go on.
  CHECK_FALSE(fs::exists(folder.path() / "new/deep"));
  CHECK_FALSE(fs::exists(folder.path() / "new/s.h5"));
  CHECK(fs::exists(folder.path() / "new/s.checkpoint.h5"));
}

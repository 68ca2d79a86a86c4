// SPDX-License-Identifier: AGPL-3.0-or-later
// The executable as launchers start it whose tasks MPI does not connect, and its threads.

#include "tests/hemocell_adapter/executable.h"
#include "tests/support/catch.h"

using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

/// Without the variables of a launcher of this test.
std::string environment(const std::string& variables) {
  return "env -u OMPI_COMM_WORLD_SIZE -u PMIX_RANK -u PMI_SIZE -u PMI_FD -u SLURM_STEP_NUM_TASKS -u "
         "SLURM_PROCID "
         "-u SLURM_PTY_PORT -u SLURM_CPUS_PER_TASK -u OMP_NUM_THREADS " +
         variables;
}

constexpr char box[] = "20 20 20 --hematocrit 0.2";

}  // namespace

TEST_CASE("Copies that MPI does not connect write nothing, and one of them says what to do", "[executable]") {
  const TemporaryFolder folder;
  for (const std::string& launcher : {std::string("SLURM_STEP_NUM_TASKS=3 SLURM_NTASKS=3 SLURM_PROCID="),
                                      std::string("MPI_LOCALNRANKS=3 PMI_SIZE=3 PMI_FD=77 PMI_RANK=")}) {
    CAPTURE(launcher);
    const Ran first = withExit(6, runProcess(folder, box, environment(launcher + "0")));
    CHECK_THAT(first.err, Contains("started 3 copies") && Contains("nothing was packed"));
    CHECK(first.out.empty());
    CHECK(withExit(6, runProcess(folder, box, environment(launcher + "1"))).all().empty());
    CHECK(fs::is_empty(folder.path()));
  }
}

TEST_CASE("A batch script packs on one rank, whatever the number of tasks of its job", "[executable]") {
  const TemporaryFolder folder;
  CHECK_THAT(
      withExit(0,
               runProcess(folder.path(), box,
                          environment("SLURM_JOB_ID=7 SLURM_NTASKS=3 SLURM_PROCID=0 SLURM_CPUS_PER_TASK=1")))
          .out,
      Contains("1 rank\n") && !Contains("threads"));
  CHECK(fs::exists(folder / "RBC.pos"));
}

TEST_CASE("OMP_NUM_THREADS is a number of threads or an error", "[executable]") {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& threads, const std::string& more = "") {
    return runProcess(folder, std::string(box) + " --dry-run" + more,
                      environment("OMP_NUM_THREADS='" + threads + "'"));
  };
  for (const char* wrong :
       {"99999999999", "99999999999999999999", "5000", "1e3", "0", "-2", "x", "2x", ",2"}) {
    CAPTURE(wrong);
    CHECK_THAT(
        withExit(1, with(wrong)).err,
        Contains("OMP_NUM_THREADS: expected an integer from 1 to 1024, found '" + std::string(wrong) + "'"));
  }
  CHECK(with("1e3", " --threads 2").exitCode == 0);  // not read
  CHECK_THAT(with(" 3 ").out, Contains("with 3 threads"));
  CHECK_THAT(with("3,2").out, Contains("with 3 threads"));
  CHECK(with("").exitCode == 0);
}

// SPDX-License-Identifier: AGPL-3.0-or-later
#include <list>

#include "packMesh/parallel/launcher.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

TEST_CASE("Numbers in the environment are read as a whole") {
  const char* variable = "PACKMESH_TEST_NUMBER";
  const auto numberOf = [&](const char* text, char end = '\0') {
    ::setenv(variable, text, 1);
    return numberInEnvironment(variable, end);
  };
  ::unsetenv(variable);
  CHECK_FALSE(numberInEnvironment(variable));
  CHECK_FALSE(numberOf(""));
  CHECK_FALSE(numberOf("  "));
  CHECK(numberOf("4") == 4);
  CHECK(numberOf(" 12\n") == 12);
  CHECK(numberOf("4 , 2", ',') == 4);
  CHECK(numberOf("-3") == -3);
  for (const char* wrong : {"four", "4x", "4,2", ",", "1e3", "99999999999999999999"})
    CHECK(numberOf(wrong) == -1);
  CHECK(numberOf(", 2", ',') == -1);
  ::unsetenv(variable);
}

namespace {

/// The environment of a launcher, instead of that of this test, which a launcher may have started.
class RankEnvironment {
 public:
  explicit RankEnvironment(const std::vector<std::pair<std::string, std::string>>& variables) {
    for (const char* name :
         {"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", "PMI_SIZE", "PMI_RANK", "PMI_FD", "MPI_LOCALNRANKS",
          "PMIX_RANK", "SLURM_STEP_NUM_TASKS", "SLURM_PROCID", "SLURM_PTY_PORT", "SLURM_NTASKS"})
      all_.emplace_back(name, std::nullopt);
    for (const auto& [name, text] : variables) setenv(name.c_str(), text.c_str(), 1);
  }

 private:
  std::list<test::Variable> all_;
};

}  // namespace

TEST_CASE("The number of tasks is found in the variables of launchers", "[parallel]") {
  struct Case {
    std::vector<std::pair<std::string, std::string>> variables;
    int count, number;
    Launcher launcher;
    bool hasTerminal = false;
  };
  const std::vector<std::pair<std::string, std::string>> step = {
      {"SLURM_NTASKS", "3"}, {"SLURM_STEP_NUM_TASKS", "3"}, {"SLURM_PROCID", "2"}};
  const auto with = [](std::vector<std::pair<std::string, std::string>> all,
                       const std::vector<std::pair<std::string, std::string>>& more) {
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  for (const Case& c :
       {Case{{}, 1, 0, Launcher::none},
        Case{{{"OMPI_COMM_WORLD_SIZE", "4"}, {"OMPI_COMM_WORLD_RANK", "3"}, {"PMIX_RANK", "3"}},
             4,
             3,
             Launcher::ofOpenMpi},
        Case{{{"MPI_LOCALNRANKS", "2"}, {"PMI_SIZE", "2"}, {"PMI_RANK", "1"}, {"PMI_FD", "6"}},
             2,
             1,
             Launcher::hydra},
        Case{step, 3, 2, Launcher::slurm},
        Case{with(step, {{"PMI_FD", "11"}, {"PMI_SIZE", "3"}, {"PMI_RANK", "2"}}), 3, 2, Launcher::slurmPmi2},
        Case{with(step, {{"PMIX_RANK", "2"}}), 3, 2, Launcher::pmix},
        Case{{{"PMIX_RANK", "2"}}, 3, 2, Launcher::pmix},
        // A batch script, the shell of an interactive job, an mpirun in a job of three nodes:
        Case{{{"SLURM_NTASKS", "3"}, {"SLURM_PROCID", "0"}}, 1, 0, Launcher::none},
        Case{with(step, {{"SLURM_PTY_PORT", "33131"}, {"PMIX_RANK", "0"}}), 1, 0, Launcher::none, true},
        Case{with(step, {{"SLURM_PTY_PORT", "33131"}, {"PMIX_RANK", "2"}}), 3, 2, Launcher::pmix},
        Case{with(step, {{"OMPI_COMM_WORLD_SIZE", "1"}, {"OMPI_COMM_WORLD_RANK", "0"}}), 1, 0,
             Launcher::ofOpenMpi},
        Case{{{"SLURM_STEP_NUM_TASKS", "many"}}, 1, 0, Launcher::none}}) {
    const RankEnvironment environment(c.variables);
    const LaunchedTasks tasks = launchedTasks(c.hasTerminal);
    CAPTURE(c.variables);
    CHECK(tasks.count == c.count);
    CHECK(tasks.number == c.number);
    CHECK(tasks.launcher == c.launcher);
  }
}

TEST_CASE("MPI is initialised only if tasks can be ranks", "[parallel]") {
  CHECK_FALSE(canBeRanks({Launcher::none, false, 1, 0}));
  CHECK_FALSE(canBeRanks({Launcher::ofOpenMpi, false, 1, 0}));
  CHECK_FALSE(canBeRanks({Launcher::pmix, true, 1, 0}));
  CHECK(canBeRanks({Launcher::ofOpenMpi, false, 2, 1}));
  CHECK(canBeRanks({Launcher::pmix, true, 2, 0}));
  // Whether by PMI-2 or not: Open MPI cannot, others can.
  CHECK(canBeRanks({Launcher::slurmPmi2, true, 2, 0}) == canBeRanks({Launcher::hydra, false, 2, 0}));
  CHECK(canBeRanks({Launcher::pmix, false, 1, 0}));  // the number of tasks is not known
}

TEST_CASE("The message to tasks that are not connected names the remedy", "[parallel]") {
  const std::string bySrun = notConnectedText({Launcher::slurm, true, 4, 0});
  CHECK_THAT(bySrun, Contains("srun started 4 copies") && Contains("Add --mpi=pm") && Contains("--ntasks=1"));
  const std::string byOther = notConnectedText({Launcher::hydra, false, 2, 0});
  CHECK_THAT(byOther,
             Contains("mpirun started 2 copies") && Contains("with the mpirun of ") && !Contains("--mpi="));
}

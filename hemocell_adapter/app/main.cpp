// SPDX-License-Identifier: AGPL-3.0-or-later
// The packMesh executable: understands the command line, does the job, tells scripts how it went.
#include <chrono>
#include <limits>
#include <optional>
#include <thread>

#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/launcher.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using namespace packmesh;
using namespace packmesh::hemocell;

/// Memory is freed and requested again at every rebuild of the neighbour lists: returning it to the system
/// each time took an eighth of the time of a million cells, as it has to be zeroed again.
void keepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

/// Of a task that a launcher started without connecting it to the others: one tells the user.
ExitCode tellNotConnected(const LaunchedTasks& tasks) {
  if (tasks.number == 0)
    log::error(notConnectedText(tasks));
  else  // launchers can end all tasks with the first one
    std::this_thread::sleep_for(std::chrono::seconds(1));
  return ExitCode::notConnected;
}

}  // namespace

int main(int argc, char** argv) {
  keepFreedMemory();
  const std::vector<std::string> arguments(argv + (argc > 0), argv + argc);
  std::optional<MpiSession> mpi;
  Communicator ranks;
  const LaunchedTasks tasks = launchedTasks();
  if (canBeRanks(tasks)) {
    mpi.emplace();
    ranks = Communicator::world();
    if (ranks.rank() > 0) log::setLevel(log::Level::silent);
  }
  if (tasks.several() && ranks.size() == 1) return int(tellNotConnected(tasks));
  const ExitCode code = runAndTell(argc > 0 ? argv[0] : "packMesh", arguments, ranks);
  ignoreInterruption();
  return int(code);
}

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/interruption.h"

#include <signal.h>
#include <unistd.h>

#include "hemocell_adapter/exit_codes.h"

namespace packmesh::hemocell {
namespace {

volatile sig_atomic_t flag = 0, polled = 0;

extern "C" void onSignal(int) {
  if (polled && !flag) {
    flag = 1;
    return;
  }
  constexpr char message[] = "(packMesh) (Error) interrupted\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
  _exit(int(ExitCode::interrupted));
}

}  // namespace

void catchInterruption() {
  struct sigaction action = {};
  action.sa_handler = onSignal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

PolledInterruption::PolledInterruption() {
  polled = 1;
}
PolledInterruption::~PolledInterruption() {
  polled = 0;
}

bool interrupted() {
  return flag != 0;
}

}  // namespace packmesh::hemocell

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/interruption.h"

#include <signal.h>
#include <unistd.h>

#include "hemocell_adapter/exit_codes.h"

namespace packmesh::hemocell {
namespace {

volatile sig_atomic_t flag = 0;

extern "C" void onSignal(int) {
  if (flag) _exit(int(ExitCode::interrupted));
  flag = 1;
}

}  // namespace

void catchInterruption() {
  struct sigaction action = {};
  action.sa_handler = onSignal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() {
  return flag != 0;
}

}  // namespace packmesh::hemocell

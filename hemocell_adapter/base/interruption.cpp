// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/interruption.h"

#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <cstddef>

#include "hemocell_adapter/base/exit_codes.h"

namespace packmesh::hemocell {
namespace {

/// From Ctrl-C, batch systems, a closed terminal, a limit of CPU time.
constexpr int endingSignals[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU};

volatile sig_atomic_t flag = 0, polled = 0, checkpoint = 0;
volatile time_t firstAt = 0;  ///< when the flag was set [s], monotonic

/// timeout, mpirun and batch systems send the same signal both to a process and to its group: signals within
/// this time count as one [s].
constexpr time_t sameSignal = 2;

time_t now() {
  timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec;
}

[[noreturn]] void endNow(const char* message, std::size_t length) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message, length);
  _exit(int(ExitCode::interrupted));
}

extern "C" void onSignal(int) {
  constexpr char early[] = "(packMesh) (Error) interrupted: nothing was written\n";
  constexpr char again[] = "(packMesh) (Error) interrupted again: ended immediately\n";
  if (!polled && !flag) endNow(early, sizeof early - 1);
  if (!flag) {
    firstAt = now();  // first, because the other signal can arrive in between
    flag = 1;
  } else if (now() - firstAt >= sameSignal) {
    endNow(again, sizeof again - 1);
  }
}

extern "C" void onCheckpointSignal(int) {
  checkpoint = 1;
}

void handle(int number, void (*handler)(int)) {
  struct sigaction action = {};
  if (number == SIGHUP && sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN)
    return;  // nohup
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

}  // namespace

void catchSignals() {
  for (const int number : endingSignals) handle(number, onSignal);
  handle(SIGUSR1, onCheckpointSignal);
  signal(SIGXFSZ, SIG_IGN);  // beyond a file size limit, write() then returns an error
}

void ignoreInterruption() {
  for (const int number : endingSignals) signal(number, SIG_IGN);
}

void pollInterruption() {
  polled = 1;
}

bool interrupted() {
  return flag != 0;
}

bool checkpointAsked() {
  return checkpoint != 0;
}
void forgetCheckpointAsked() {
  checkpoint = 0;
}

}  // namespace packmesh::hemocell

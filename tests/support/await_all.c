/* SPDX-License-Identifier: AGPL-3.0-or-later
 * await_all COMMAND [ARGUMENT ...]: runs a command and waits for everything that it has started. mpirun sends SIGTERM to the
 * ranks after the first non-zero exit code, a second later SIGKILL, and returns without waiting: on a busy machine ranks then
 * still write files, or hold locks, of which a test looks at the state.
 * Signals that ask it to end go to the command. The exit code is that of the command, as in a shell. */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

static const unsigned patience = 300; /* [s] after the end of the command */
static volatile pid_t command = -1;

static void pass_on(int number) {
  if (command > 0) kill(command, number);
}
static void give_up(int number) {
  static const char message[] = "await_all: what the command has started is still running\n";
  (void)number;
  if (write(STDERR_FILENO, message, sizeof message - 1) < 0) _exit(124);
  _exit(124);
}

int main(int argc, char** argv) {
  static const int passed_on[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2};
  sigset_t held, before;
  int code = 127, status = 0;
  if (argc < 2 || prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) != 0) return 127;
  sigemptyset(&held);
  for (unsigned i = 0; i < sizeof passed_on / sizeof *passed_on; ++i) sigaddset(&held, passed_on[i]);
  sigprocmask(SIG_BLOCK, &held, &before); /* until the command exists */
  const pid_t child = fork();
  if (child == 0) {
    sigprocmask(SIG_SETMASK, &before, NULL);
    execvp(argv[1], argv + 1);
    fprintf(stderr, "await_all: %s: %s\n", argv[1], strerror(errno));
    _exit(127);
  }
  if (child < 0) return 127;
  command = child;
  for (unsigned i = 0; i < sizeof passed_on / sizeof *passed_on; ++i) signal(passed_on[i], pass_on);
  signal(SIGALRM, give_up);
  sigprocmask(SIG_SETMASK, &before, NULL);
  for (;;) {
    const pid_t ended = waitpid(-1, &status, 0);
    if (ended < 0 && errno == EINTR) continue;
    if (ended < 0) return code; /* nothing is left */
    if (ended != child) continue;
    command = -1;
    code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    alarm(patience);
  }
}

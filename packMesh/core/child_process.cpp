// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/child_process.h"

#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

namespace packmesh {
namespace {

constexpr int betweenPolls = 50;  // [ms]

void writeAll(int to, const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = write(to, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno != EINTR) return;
    if (n > 0) at += static_cast<std::size_t>(n);
  }
}

[[noreturn]] void child(pid_t parent, int to, const std::function<std::string()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  // The parent alone reacts to signals sent to the process group.
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1}) signal(number, SIG_IGN);
  writeAll(to, work());
  _exit(0);
}

/// Reads until the other end is closed. @return false if `stop` returned true before that
bool readAll(int from, const std::function<bool()>& stop, std::string& bytes) {
  char buffer[1 << 16];
  for (;;) {
    pollfd waiting{from, POLLIN, 0};
    const int ready = poll(&waiting, 1, betweenPolls);
    if (stop && stop()) return false;
    if (ready <= 0) continue;
    const ssize_t n = read(from, buffer, sizeof buffer);
    if (n == 0) return true;
    if (n > 0) bytes.append(buffer, static_cast<std::size_t>(n));
  }
}

}  // namespace

ChildOutcome inChildProcess(const std::function<std::string()>& work, const std::function<bool()>& stop) {
  using End = ChildOutcome::End;
  if (stop && stop()) return {End::stopped, {}};
  int ends[2];
  if (pipe(ends) != 0) return {End::done, work()};
  const pid_t parent = getpid(), id = fork();
  if (id == 0) {
    close(ends[0]);
    child(parent, ends[1], work);
  }
  close(ends[1]);
  if (id < 0) {
    close(ends[0]);
    return {End::done, work()};
  }
  ChildOutcome outcome;
  const bool ended = readAll(ends[0], stop, outcome.bytes);
  close(ends[0]);
  if (!ended) kill(id, SIGKILL);
  int status = 0;
  while (waitpid(id, &status, 0) < 0 && errno == EINTR) continue;
  if (!ended)
    outcome = {End::stopped, {}};
  else if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    outcome = {End::died, {}};
  return outcome;
}

}  // namespace packmesh

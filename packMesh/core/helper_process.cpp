// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/helper_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace packmesh {
namespace {

constexpr int dataOfHelper = 3;              ///< its descriptor
constexpr std::size_t mostWords = 64 << 10;  // [bytes]

/// What it may inherit: where libraries are, and the options of sanitizers. Neither LD_PRELOAD, which may
/// name libraries that use MPI, nor anything of MPI, PMIx or Slurm.
constexpr const char* inherited[] = {"PATH",         "LD_LIBRARY_PATH", "LANG",        "TMPDIR",
                                     "ASAN_OPTIONS", "UBSAN_OPTIONS",   "TSAN_OPTIONS"};

/// Those that are sent to whole jobs and terminals: this process alone reacts to them.
constexpr int blocked[] = {SIGINT,  SIGTERM, SIGHUP,  SIGQUIT, SIGXCPU, SIGUSR1,
                           SIGUSR2, SIGTSTP, SIGALRM, SIGPIPE, SIGCONT};

/// Closes a descriptor at the end of its scope.
struct Descriptor {
  int number = -1;
  Descriptor() = default;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) close(number);
  }
  int release() { return std::exchange(number, -1); }
};

/// Moves a descriptor above those of the helper, which may be free in this process.
bool raise(Descriptor& descriptor) {
  const int above = fcntl(descriptor.number, F_DUPFD_CLOEXEC, dataOfHelper + 1);
  if (above < 0) return false;
  close(descriptor.number);
  descriptor.number = above;
  return true;
}

/// The ends of a socket and a pipe, ours first. Closed in other programs that are started meanwhile.
bool connect(Descriptor (&data)[2], Descriptor (&printed)[2]) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return false;
  data[0].number = ends[0], data[1].number = ends[1];
  if (pipe2(ends, O_CLOEXEC) != 0) return false;
  printed[0].number = ends[0], printed[1].number = ends[1];
  for (Descriptor* end : {&data[0], &data[1], &printed[0], &printed[1]})
    if (!raise(*end)) return false;
  return fcntl(data[0].number, F_SETFL, O_NONBLOCK) == 0 &&
         fcntl(printed[0].number, F_SETFL, O_NONBLOCK) == 0;
}

std::vector<char*> pointersTo(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> environmentOfHelper() {
  std::vector<std::string> variables;
  for (const char* name : inherited)
    if (const char* value = std::getenv(name)) variables.push_back(std::string(name) + "=" + value);
  return variables;
}

/// @return 0 or the number of an error
int spawn(const std::string& program, std::vector<std::string> arguments, int data, int printed, pid_t& id) {
  arguments.insert(arguments.begin(), program);
  std::vector<std::string> environment = environmentOfHelper();
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  if (const int error = posix_spawn_file_actions_init(&files)) return error;
  if (const int error = posix_spawnattr_init(&attributes)) {
    posix_spawn_file_actions_destroy(&files);
    return error;
  }
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, printed, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, printed, STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&files, data, dataOfHelper);
#if __GLIBC_PREREQ(2, 34)
  posix_spawn_file_actions_addclosefrom_np(&files, dataOfHelper + 1);  // those of MPI, locks ...
#endif
  sigset_t mask, byDefault;
  sigemptyset(&mask);
  for (const int number : blocked) sigaddset(&mask, number);
  sigfillset(&byDefault);
  posix_spawnattr_setsigmask(&attributes, &mask);
  posix_spawnattr_setsigdefault(&attributes, &byDefault);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawn(&id, program.c_str(), &files, &attributes, pointersTo(arguments).data(),
                                pointersTo(environment).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

std::string faultOf(int status) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    return "was ended by signal " + std::to_string(number) + " (" + strsignal(number) + ")";
  }
  return WEXITSTATUS(status) == 0 ? "" : "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

bool wouldBlock() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

HelperProcess::HelperProcess(const std::string& program, std::vector<std::string> arguments,
                             std::string request, std::size_t mostBytes)
    : request_(std::move(request)), mostBytes_(mostBytes) {
  Descriptor data[2], printed[2];
  int error = connect(data, printed) ? 0 : errno;
  if (error == 0) error = spawn(program, std::move(arguments), data[1].number, printed[1].number, id_);
  if (error != 0) {
    id_ = -1;
    fault_ = std::string("cannot be started: ") + std::strerror(error);
    return;
  }
  data_ = data[0].release();
  printed_ = printed[0].release();
}

HelperProcess::~HelperProcess() {
  if (data_ >= 0) end();
}

bool HelperProcess::wait(int milliseconds) {
  if (data_ < 0) return true;
  pollfd waiting[2] = {{data_, static_cast<short>(sending_ ? POLLIN | POLLOUT : POLLIN), 0},
                       {printed_, POLLIN, 0}};  // a negative descriptor is ignored
  if (poll(waiting, 2, milliseconds) <= 0) return false;
  if (waiting[1].revents != 0) receiveWords();
  if (sending_ && (waiting[0].revents & POLLOUT) != 0) send();
  if ((waiting[0].revents & ~POLLOUT) != 0) receiveAnswer();
  return data_ < 0;
}

void HelperProcess::send() {
  // Not write(): of a helper that is gone, the answer tells enough, and SIGPIPE would end this process.
  const ssize_t n = ::send(data_, request_.data() + sent_, request_.size() - sent_, MSG_NOSIGNAL);
  if (n > 0) sent_ += static_cast<std::size_t>(n);
  if (n < 0 && !wouldBlock()) sent_ = request_.size();
  if (sent_ < request_.size()) return;
  shutdown(data_, SHUT_WR);
  request_ = std::string();
  sending_ = false;
}

void HelperProcess::receiveAnswer() {
  char buffer[1 << 16];
  const ssize_t n = recv(data_, buffer, sizeof buffer, 0);
  if (n > 0) {
    answer_.append(buffer, static_cast<std::size_t>(n));
    if (answer_.size() <= mostBytes_) return;
    answer_.clear();
    fault_ = "sent more than " + std::to_string(mostBytes_) + " bytes";
  } else if (n < 0 && wouldBlock()) {
    return;
  }
  end();
}

void HelperProcess::receiveWords() {
  char buffer[1 << 12];
  const ssize_t n = read(printed_, buffer, sizeof buffer);
  if (n < 0 && wouldBlock()) return;
  if (n <= 0) {
    close(std::exchange(printed_, -1));
    return;
  }
  for (ssize_t k = 0; k < n && words_.size() < mostWords; ++k) {
    const bool space = buffer[k] == '\n' || buffer[k] == ' ';
    if (!space)
      words_ += buffer[k];
    else if (!words_.empty() && words_.back() != ' ')
      words_ += ' ';
  }
}

/// A program that has closed its descriptors has nothing to do any more: the signal does not change the
/// status of one that is about to exit, and ends any other, and those that it has started.
void HelperProcess::end() {
  kill(-id_, SIGKILL);
  int status = 0;
  pid_t ended;
  while ((ended = waitpid(id_, &status, 0)) < 0 && errno == EINTR) continue;
  if (ended == id_ && fault_.empty()) fault_ = faultOf(status);  // otherwise SIGCHLD is ignored
  while (printed_ >= 0) {
    const std::size_t before = words_.size();
    receiveWords();
    if (printed_ >= 0 && words_.size() == before) close(std::exchange(printed_, -1));
  }
  if (!words_.empty() && words_.back() == ' ') words_.pop_back();
  close(std::exchange(data_, -1));
}

}  // namespace packmesh

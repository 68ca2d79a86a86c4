// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/process.h"

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
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

namespace packmesh {

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  if (this != &other) {
    close();
    number_ = std::exchange(other.number_, -1);
  }
  return *this;
}

void Descriptor::close() {
  if (isOpen()) ::close(std::exchange(number_, -1));
}

bool Descriptor::raise(int least) {
  const int raised = fcntl(number_, F_DUPFD_CLOEXEC, least);
  if (raised < 0) return false;
  *this = Descriptor(raised);
  return true;
}

namespace {

std::vector<char*> pointersTo(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// What is done to the files of a process before its program starts. @return 0, or the number of an error
int setFiles(posix_spawn_file_actions_t& actions, const std::vector<int>& descriptors) {
  const int n = static_cast<int>(descriptors.size());
  int error = 0;
  for (int k = 0; k < n && error == 0; ++k)
    error = descriptors[k] < 0 ? posix_spawn_file_actions_addopen(&actions, k, "/dev/null", O_RDWR, 0)
                               : posix_spawn_file_actions_adddup2(&actions, descriptors[k], k);
#if __GLIBC_PREREQ(2, 34)
  if (error == 0) error = posix_spawn_file_actions_addclosefrom_np(&actions, n);  // of MPI, locks ...
#endif
  return error;
}

/// Signals and the group of a process. @return 0, or the number of an error
int setAttributes(posix_spawnattr_t& attributes, const std::vector<int>& blockedSignals, bool ownGroup) {
  sigset_t mask, byDefault;
  sigemptyset(&mask);
  for (const int number : blockedSignals) sigaddset(&mask, number);
  sigfillset(&byDefault);
  posix_spawnattr_setsigmask(&attributes, &mask);
  posix_spawnattr_setsigdefault(&attributes, &byDefault);
  posix_spawnattr_setpgroup(&attributes, 0);
  return posix_spawnattr_setflags(&attributes,
                                  static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                     (ownGroup ? POSIX_SPAWN_SETPGROUP : 0)));
}

/// Ends what a function of the system has begun.
template <class T>
using Ended = std::unique_ptr<T, int (*)(T*)>;

}  // namespace

int spawn(const StartedProgram& program, pid_t& id) {
  posix_spawn_file_actions_t files;
  if (const int error = posix_spawn_file_actions_init(&files)) return error;
  const Ended<posix_spawn_file_actions_t> endFiles(&files, posix_spawn_file_actions_destroy);
  if (const int error = setFiles(files, program.descriptors)) return error;
  posix_spawnattr_t attributes;
  if (const int error = posix_spawnattr_init(&attributes)) return error;
  const Ended<posix_spawnattr_t> endAttributes(&attributes, posix_spawnattr_destroy);
  if (const int error = setAttributes(attributes, program.blockedSignals, program.ownGroup)) return error;
  const std::vector<char*> words = pointersTo(program.words), environment = pointersTo(program.environment);
  return posix_spawnp(&id, words[0], &files, &attributes, words.data(), environment.data());
}

std::optional<int> statusAtEnd(pid_t id) {
  int status = 0;
  pid_t ended;
  while ((ended = waitpid(id, &status, 0)) < 0 && errno == EINTR) continue;
  return ended == id ? std::optional<int>(status) : std::nullopt;
}

bool makePipe(Descriptor& read, Descriptor& write) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return false;
  read = Descriptor(ends[0]);
  write = Descriptor(ends[1]);
  return read.raise(leastOwnDescriptor) && write.raise(leastOwnDescriptor);
}

bool isProgram(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

namespace {

constexpr std::size_t mostWords = 64 << 10;  // [bytes]

/// What it may inherit: where libraries are, and the options of sanitizers. Neither LD_PRELOAD, which may
/// name libraries that use MPI, nor anything of MPI, PMIx or Slurm.
constexpr const char* inherited[] = {"PATH",         "LD_LIBRARY_PATH", "LANG",        "TMPDIR",
                                     "ASAN_OPTIONS", "UBSAN_OPTIONS",   "TSAN_OPTIONS"};

/// Those that are sent to whole jobs and terminals: this process alone reacts to them.
const std::vector<int> blocked = {SIGINT,  SIGTERM, SIGHUP,  SIGQUIT, SIGXCPU, SIGUSR1,
                                  SIGUSR2, SIGTSTP, SIGALRM, SIGPIPE, SIGCONT};

/// The ends of a socket, ours first. @return false, with errno, if not possible
bool makeSocket(Descriptor& ours, Descriptor& theirs) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return false;
  ours = Descriptor(ends[0]);
  theirs = Descriptor(ends[1]);
  return ours.raise(leastOwnDescriptor) && theirs.raise(leastOwnDescriptor);
}

bool doesNotBlock(const Descriptor& descriptor) {
  return fcntl(descriptor.number(), F_SETFL, O_NONBLOCK) == 0;
}

std::vector<std::string> environmentOfHelper() {
  std::vector<std::string> variables;
  for (const char* name : inherited)
    if (const char* value = std::getenv(name)) variables.push_back(std::string(name) + "=" + value);
  return variables;
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
  Descriptor theirData, theirPrint;
  const bool connected = makeSocket(data_, theirData) && makePipe(printed_, theirPrint) &&
                         doesNotBlock(data_) && doesNotBlock(printed_);
  int error = errno;
  if (connected) {
    StartedProgram start;
    start.words = std::move(arguments);
    start.words.insert(start.words.begin(), program);
    start.environment = environmentOfHelper();
    start.descriptors = {-1, theirPrint.number(), theirPrint.number(), theirData.number()};
    start.blockedSignals = blocked;
    start.ownGroup = true;
    error = spawn(start, id_);
  }
  if (connected && error == 0) return;
  fault_ = std::string("cannot be started: ") + std::strerror(error);
  data_.close();
  printed_.close();
}

HelperProcess::~HelperProcess() {
  if (data_.isOpen()) end();
}

bool HelperProcess::wait(int milliseconds) {
  if (!data_.isOpen()) return true;
  pollfd waiting[2] = {{data_.number(), static_cast<short>(sending_ ? POLLIN | POLLOUT : POLLIN), 0},
                       {printed_.number(), POLLIN, 0}};  // a negative descriptor is ignored
  if (poll(waiting, 2, milliseconds) <= 0) return false;
  if (waiting[1].revents != 0) receiveWords();
  if (sending_ && (waiting[0].revents & POLLOUT) != 0) send();
  if ((waiting[0].revents & ~POLLOUT) != 0) receiveAnswer();
  return !data_.isOpen();
}

void HelperProcess::send() {
  // Not write(): of a helper that is gone, the answer tells enough, and SIGPIPE would end this process.
  const ssize_t n = ::send(data_.number(), request_.data() + sent_, request_.size() - sent_, MSG_NOSIGNAL);
  if (n > 0) sent_ += static_cast<std::size_t>(n);
  if (n < 0 && !wouldBlock()) sent_ = request_.size();
  if (sent_ < request_.size()) return;
  shutdown(data_.number(), SHUT_WR);
  request_ = std::string();
  sending_ = false;
}

void HelperProcess::receiveAnswer() {
  char buffer[1 << 16];
  const ssize_t n = recv(data_.number(), buffer, sizeof buffer, 0);
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
  const ssize_t n = read(printed_.number(), buffer, sizeof buffer);
  if (n < 0 && wouldBlock()) return;
  if (n <= 0) {
    printed_.close();
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
  const std::optional<int> status = statusAtEnd(id_);
  if (status && fault_.empty()) fault_ = faultOf(*status);
  while (printed_.isOpen()) {
    const std::size_t before = words_.size();
    receiveWords();
    if (words_.size() == before) printed_.close();
  }
  if (!words_.empty() && words_.back() == ' ') words_.pop_back();
  data_.close();
}

}  // namespace packmesh

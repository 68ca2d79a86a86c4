// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Other programs: starting them by any thread and without fork(), and those that work for this one and
/// may crash, hang or be ended.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace packmesh {

/// Owns a file descriptor; a negative number is none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { close(); }

  int number() const { return number_; }
  bool isOpen() const { return number_ >= 0; }
  void close();
  /// Moves it to the first free number that is not below `least`; closed in programs that are started.
  /// @return false, with errno, if there is none
  bool raise(int least);

 private:
  int number_ = -1;
};

/// A program may be given descriptors 0-3. Ours that it gets are not below this, so that none is overwritten.
constexpr int leastOwnDescriptor = 4;

struct StartedProgram {
  std::vector<std::string> words;  ///< the program, looked for in PATH if it has no slash, and its arguments
  std::vector<std::string> environment = {};  ///< "NAME=value"
  /// Ours that become its 0, 1, ...; -1 is /dev/null. All others are closed in it (glibc before 2.34: those
  /// that are marked so).
  std::vector<int> descriptors = {};
  std::vector<int> blockedSignals = {};  ///< all others act in the default way
  bool ownGroup = false;                 ///< it is the first of a new process group
};

/// @return 0, or the number of an error of the system; `id` is that of the process
int spawn(const StartedProgram& program, pid_t& id);

/// Waits for the end of a process of ours. @return its status as of waitpid(); empty where SIGCHLD is ignored
std::optional<int> statusAtEnd(pid_t id);

/// Both ends, ours (see leastOwnDescriptor). @return false, with errno, if not possible
bool makePipe(Descriptor& read, Descriptor& write);

/// Whether this is a file that this user may execute.
bool isProgram(const std::filesystem::path& file);

/// A program that gets a request and returns an answer. It reads the request from file descriptor 3, up to
/// the end, and writes the answer to it; what it prints are words for messages. Any number can run at once,
/// started by any threads.
///
/// It starts without the open files of this process, and with few variables of its environment: none of those
/// by which MPI connects ranks. It is in a process group of its own and blocks the signals that ask programs
/// to stop: it ends when this object or this process does (it notices that descriptor 3 is closed at the
/// other end).
class HelperProcess {
 public:
  /// @param mostBytes an answer of more bytes ends the program
  /// A program that cannot be started has ended, and fault() tells why.
  HelperProcess(const std::string& program, std::vector<std::string> arguments, std::string request,
                std::size_t mostBytes);
  ~HelperProcess();
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;

  /// Exchanges bytes for at most this long [ms], less if a signal arrives. @return whether the program has
  /// ended
  bool wait(int milliseconds);

  /// What the program wrote to descriptor 3. Pre: it has ended
  const std::string& answer() const { return answer_; }
  /// The beginning of what it printed, as one line. Pre: it has ended
  const std::string& words() const { return words_; }
  /// "was ended by signal 9 (Killed)", "ended with exit code 1", "cannot be started: ..."; empty after exit
  /// code 0. Pre: it has ended
  const std::string& fault() const { return fault_; }

 private:
  void send();
  void receiveAnswer();
  void receiveWords();
  void end();

  std::string request_;
  std::size_t sent_ = 0, mostBytes_;
  bool sending_ = true;
  std::string answer_, words_, fault_;
  pid_t id_ = -1;
  Descriptor data_, printed_;  ///< our ends: of the socket, and of the pipe that it prints to
};

}  // namespace packmesh

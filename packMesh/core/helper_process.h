// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Another program that works for this one and may crash, hang or be ended.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

#include "packMesh/core/descriptor.h"

namespace packmesh {

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

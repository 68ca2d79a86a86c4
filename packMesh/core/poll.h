// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Ending of work that takes long and has no limits of its own: reading, repairing and preparing
/// meshes.
#pragma once

#include <cstddef>
#include <functional>
#include <utility>

namespace packmesh {

/// While it exists, poll() calls `ask` on the thread that created it; `ask` throws to end the work. Scopes of
/// one thread are destroyed in reverse order.
class PollScope {
 public:
  explicit PollScope(std::function<void()> ask) : ask_(std::move(ask)), before_(innermost) {
    innermost = &ask_;
  }
  ~PollScope() { innermost = before_; }
  PollScope(const PollScope&) = delete;
  PollScope& operator=(const PollScope&) = delete;

 private:
  friend void poll();
  inline static thread_local const std::function<void()>* innermost = nullptr;

  std::function<void()> ask_;
  const std::function<void()>* before_;
};

/// Throws what the innermost PollScope of this thread throws; nothing without one. To be called at least
/// every few milliseconds in loops that can take seconds.
inline void poll() {
  if (PollScope::innermost && *PollScope::innermost) (*PollScope::innermost)();
}

/// Calls poll() for one of 1024 items of a loop.
inline void pollAt(std::size_t item) {
  if ((item & 1023) == 0) poll();
}

}  // namespace packmesh

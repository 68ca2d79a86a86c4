// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What poll() asks.
#pragma once

#include <functional>

namespace packmesh {

/// While it exists, poll() calls `ask` on the thread that created it; `ask` throws to end the work. Scopes of
/// one thread are destroyed in reverse order.
class PollScope {
 public:
  explicit PollScope(std::function<void()> ask);
  ~PollScope();
  PollScope(const PollScope&) = delete;
  PollScope& operator=(const PollScope&) = delete;

 private:
  std::function<void()> ask_;
  const std::function<void()>* before_;
};

}  // namespace packmesh

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/poll.h"

#include <functional>
#include <utility>

namespace packmesh {
namespace {

thread_local const std::function<void()>* innermost = nullptr;

}  // namespace

PollScope::PollScope(std::function<void()> ask) : ask_(std::move(ask)), before_(innermost) {
  innermost = &ask_;
}

PollScope::~PollScope() {
  innermost = before_;
}

void poll() {
  if (innermost && *innermost) (*innermost)();
}

}  // namespace packmesh

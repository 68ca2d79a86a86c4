// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/held_signals.h"

#include "hemocell_adapter/base/interruption.h"

namespace packmesh::hemocell {

HeldSignals::HeldSignals() {
  sigset_t held;
  sigemptyset(&held);
  for (const int number : endingSignals) sigaddset(&held, number);
  pthread_sigmask(SIG_BLOCK, &held, &before_);
}
HeldSignals::~HeldSignals() {
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace packmesh::hemocell

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/descriptor.h"

#include <fcntl.h>
#include <unistd.h>

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

}  // namespace packmesh

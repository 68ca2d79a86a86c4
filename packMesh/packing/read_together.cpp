// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/read_together.h"

#include <string>

#include "packMesh/core/error.h"

namespace packmesh {

void readTogether(const std::filesystem::path& file, const Communicator& ranks,
                  const std::function<void()>& work) {
  std::string error;
  try {
    work();
  } catch (const InputError& found) {
    error = found.what();
  }
  if (ranks.any(!error.empty()))
    throw InputError(error.empty() ? file.string() + ": another rank cannot read it" : error);
}

}  // namespace packmesh

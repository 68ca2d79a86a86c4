// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reading a file on several ranks.
#pragma once

#include <filesystem>
#include <functional>

#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Every rank calls `work`, which reads `file` and does not communicate. Collective.
/// @throws InputError on all ranks if it does on one
void readTogether(const std::filesystem::path& file, const Communicator& ranks,
                  const std::function<void()>& work);

}  // namespace packmesh

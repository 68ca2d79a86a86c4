// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Numbers in environment variables.
#pragma once

#include <cstdint>
#include <optional>

namespace packmesh {

/// The whole number in an environment variable, up to `end`, without the blanks around it; -1 if something
/// else is there. Empty: the variable is not set, or to nothing.
std::optional<std::int64_t> numberInEnvironment(const char* variable, char end = '\0');

}  // namespace packmesh

// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the library throws. It never prints, exits or aborts.
#pragma once

#include <stdexcept>
#include <string>

namespace packmesh {

/// The user's input is at fault: the message says what, where, what was expected and what was found.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A mesh that cannot be packed or packed into (open, self-intersecting, degenerate ...).
class MeshError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace packmesh

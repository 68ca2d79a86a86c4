// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the library throws. It never prints, exits or aborts.
#pragma once

#include <stdexcept>
#include <string>

namespace packmesh {

/// Whatever a user can do something about. Everything else that is thrown is an internal error.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input is invalid: the message says what, where, what was expected and what was found.
class InputError : public Error {
 public:
  using Error::Error;
};

/// A mesh that cannot be packed or packed into (open, self-intersecting, degenerate ...).
class MeshError : public InputError {
 public:
  using InputError::InputError;
};

/// Results cannot be written.
class OutputError : public Error {
 public:
  using Error::Error;
};

}  // namespace packmesh

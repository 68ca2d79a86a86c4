// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exceptions of the library. The library never prints, exits or aborts.
#pragma once

#include <stdexcept>
#include <string>

namespace packmesh {

/// Errors that the user can correct. Any other exception is an internal error.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input is invalid. The message states what is invalid, where, what was expected and what was found.
class InputError : public Error {
 public:
  using Error::Error;
};

/// A mesh that cannot be packed or used as a container (open, self-intersecting, degenerate ...).
class MeshError : public InputError {
 public:
  using InputError::InputError;
};

/// Results cannot be written.
class OutputError : public Error {
 public:
  using Error::Error;
};

/// What work() returns. Its InputErrors become errors of class As that begin with `where`.
template <class As = InputError, class Work>
auto located(const std::string& where, Work&& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw As(where + ": " + error.what());
  }
}

}  // namespace packmesh

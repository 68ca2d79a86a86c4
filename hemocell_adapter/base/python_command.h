// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The command `packmesh` of the Python package, as a process of its own.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

/// How a command ended.
struct CommandEnd {
  enum class Kind {
    done,      ///< the files are written
    refused,   ///< with a message: what was asked for is not possible
    failed,    ///< with a message: files cannot be written, or an internal error
    unusable,  ///< with a message: a Python package that it needs is missing, or the command itself
    stopped,   ///< because `stop` asked for it
  };
  Kind kind = Kind::done;
  std::vector<std::string> lines;  ///< what it printed
  std::string message;             ///< its error
};

/// Looked for beside the program, then in PATH; if there is none, `python3 -m packmesh` is tried.
std::vector<std::string> packmeshCommand();

/// Runs packmesh with these arguments until it ends. Its warnings are logged.
///
/// Without the variables of the environment by which MPI knows its ranks: Python is not one of them.
/// @param stop polled ten times per second; true ends the command
CommandEnd runPackmesh(const std::vector<std::string>& arguments, const std::function<bool()>& stop = {});

/// "packmesh view 'a file' ...", as a shell reads it.
std::string asTyped(const std::vector<std::string>& arguments);

}  // namespace packmesh::hemocell

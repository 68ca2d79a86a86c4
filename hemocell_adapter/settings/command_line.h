// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parser of the command line, compatible with that of packCells.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/settings/request.h"
#include "hemocell_adapter/settings/settings_table.h"

namespace packmesh::hemocell {

enum class Command { pack, check, help, version, reference, man, completion };

/// The parsed command line.
struct CommandLine {
  Command command = Command::pack;
  bool asPackCells = false;  ///< started as packCells
  Request request;  ///< all that it states; its words are the arguments without --restart and its file
};

/// Parses `arguments` (without the program name).
///
/// Compatible with getopt_long_only, which packCells uses: one or two dashes, `--name value` and
/// `--name=value`, any order, unique prefixes; `--` ends the options. In addition, options can take several
/// values, numbers are never options (`-5`), a prefix that is unique among packCells' options denotes that
/// option (so that no new option makes a script's `--hema` ambiguous), and errors suggest the most similar
/// option.
/// Options given twice with different values are rejected, except under the name packCells, where the last
/// one counts.
/// @param programName argv[0]; its last component determines whether this is packCells
/// @throws UsageError
CommandLine parseCommandLine(const std::string& programName, const std::vector<std::string>& arguments);

/// The options alone, of words without a container. @throws UsageError
Request readOptions(const std::vector<std::string>& words);

/// A command that states the request: options and, of what has none, a `<packing>` section. Numbers in memory
/// have the name of their key, where a file would be.
std::vector<std::string> wordsOf(const Request& request);

/// The text of `--help`.
std::string helpText(bool asPackCells);

/// The reference of the `<packing>` section.
std::string referenceText();

/// The manual page, for man(1), of the same tables.
std::string manText();

/// A script by which bash completes options and their values.
std::string completionText();

}  // namespace packmesh::hemocell

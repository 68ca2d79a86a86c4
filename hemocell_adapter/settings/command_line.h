// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parser of the command line, compatible with that of packCells.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/settings/request.h"
#include "hemocell_adapter/settings/settings_table.h"

namespace packmesh::hemocell {

enum class Command { pack, check, help, version, reference, man, completion };

/// One option with its values, in the order of the command line.
struct Assignment {
  const Setting* setting = nullptr;
  std::vector<Value> values;
  std::size_t word = 0;  ///< index of its first argument
};

/// The parsed command line.
struct CommandLine {
  Command command = Command::pack;
  bool asPackCells = false;                         ///< started as packCells
  std::optional<std::filesystem::path> configFile;  ///< case mode
  std::optional<std::array<std::string, 3>> sizes;  ///< box mode, as typed
  std::vector<Assignment> assignments;
  std::vector<std::string> words;  ///< name of the program, arguments without --restart and its file
  bool restartAlone = false;       ///< --restart without a container
  /// A word that is a `<packing>` section, for settings that have no option. Options override it; it changes
  /// that of config.xml.
  std::string section;

  /// The options only.
  Request options() const;
};

/// `base`, overridden by the options.
Request withOptions(Request base, const CommandLine& commandLine);

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
/// @param earlier the first `earlier` arguments are those of an earlier command and are overridden by the
/// others
/// @throws UsageError
CommandLine parseCommandLine(const std::string& programName, const std::vector<std::string>& arguments,
                             std::size_t earlier = 0);

/// The text of `--help`.
std::string helpText(bool asPackCells);

/// The reference of the `<packing>` section.
std::string referenceText();

/// The manual page, for man(1), of the same tables.
std::string manText();

/// A script by which bash completes options and their values.
std::string completionText();

}  // namespace packmesh::hemocell

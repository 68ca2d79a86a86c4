// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The command line, packCells' and ours.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/settings/settings.h"
#include "hemocell_adapter/settings/settings_table.h"

namespace packmesh::hemocell {

enum class Command { pack, check, help, version, reference, man, completion };

/// One option with its values, in the order of the command line.
struct Assignment {
  const Setting* setting = nullptr;
  std::vector<Value> values;
  std::size_t word = 0;  ///< number of its first argument
};

/// What the user typed, understood word by word.
struct CommandLine {
  Command command = Command::pack;
  bool asPackCells = false;                         ///< started under the name packCells
  std::optional<std::filesystem::path> configFile;  ///< case mode
  std::optional<std::array<std::string, 3>> sizes;  ///< box mode, as typed
  std::vector<Assignment> assignments;
  std::vector<std::string> words;  ///< program and arguments, but for --restart and its file
  bool restartAlone = false;       ///< --restart without anything to pack into

  /// The options alone.
  Settings settings() const;
};

/// `base` with the options applied on top.
Settings withOptions(Settings base, const CommandLine& commandLine);

/// Understands `arguments` (without the program's name).
///
/// As getopt_long_only, which packCells uses, understands it: one or two dashes, `--name value` and
/// `--name=value`, any order, unique prefixes, `--` ends the options. Beyond it: options take several values,
/// words that are numbers are never options (`-5`), a prefix that is unique among packCells' options means
/// that one (so that no option of ours makes a script's `--hema` ambiguous), and errors name the option that
/// was probably meant.
/// Of options that are given twice with different values one would be lost: they are refused, but under
/// packCells' name, where the last one counts.
/// @param programName argv[0]; its last component decides whether this is packCells
/// @param earlier so many arguments are those of an earlier command, which the others override
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

// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Messages to the user in HemoCell's style, `(packMesh) (Warning) ...`, and what they consist of:
/// durations, names of settings, text of users without what terminals would obey.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace packmesh::hemocell {

/// `text` with `?` for every byte that is not plain: not UTF-8, or of control characters, byte order marks
/// and characters that change the direction of the text after them. Line ends and tabs are kept.
std::string plainText(std::string_view text);

/// `text` with the middle of every excessively long word replaced by "...". Pre: UTF-8.
std::string withShortenedNames(std::string_view text);

/// "0.25 s", "45 s", "12 min 5 s", "3 h 20 min", "12 days", "40 years", "more than 1000 years". Pre: not NaN
std::string durationText(double seconds);

/// A setting that a message names. Users state settings in different terms: as options of the program,
/// arguments of Python, members of the plug-in's struct. So messages have marks, which the front end that
/// shows them replaces by its own terms.
struct SettingName {
  std::string name;     ///< the option without dashes: "max-time"; of an attribute "species.wallClearance"
  std::string value;    ///< to be stated for it: "periodic"; empty: any
  std::string of;       ///< which of several: name of the cell or parameter, number of the body
  bool begins = false;  ///< the message is about it and begins with it
};

/// The mark of a setting, or of a value of it: "see --walls", "--ends periodic excludes --keep-all".
std::string named(const std::string& name, const std::string& value = "");
/// The mark with which a message about a setting begins: "option '--max-time': expected ...".
std::string heading(const std::string& name, const std::string& of = "");

/// "--max-time", "option '--max-time'" at the beginning.
std::string termOfProgram(const SettingName& setting);
/// Chooses the terms of the front end; those of the program are the default.
void setTerms(std::function<std::string(const SettingName&)> terms);
/// A message with the terms of the front end in place of marks.
std::string inTermsOfUser(const std::string& message);

}  // namespace packmesh::hemocell

namespace packmesh::hemocell::log {

/// silent: no messages; for all ranks except the first.
enum class Level { silent, quiet, normal, verbose };

void setLevel(Level level);
Level level();

/// What a message is; repair: a warning that a mesh of the user was changed.
enum class Kind { detail, info, warning, error, repair };
/// Messages are given to `sink` instead of being printed, unless silent; empty: they are printed.
void setSink(std::function<void(Kind, const std::string&)> sink);

/// True if standard output is a terminal used interactively (not under Slurm or mpirun).
bool isTerminal();
/// Prints a line to the terminal, unless quiet, that the next line replaces. Pre: isTerminal()
void status(const std::string& message);

/// Prints to standard output, unless quiet.
void info(const std::string& message);
/// Prints to standard output if verbose.
void detail(const std::string& message);
/// Prints to standard error, unless silent.
void warning(const std::string& message);
void repair(const std::string& message);
void error(const std::string& message);

}  // namespace packmesh::hemocell::log

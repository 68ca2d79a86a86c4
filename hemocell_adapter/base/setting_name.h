// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Names of settings in messages.
#pragma once

#include <functional>
#include <string>

namespace packmesh::hemocell {

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

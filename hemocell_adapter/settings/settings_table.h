// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The single declaration of all options and tags of `<packing>`: parsing, range checks, error
/// messages, `--help` and the reference are derived from it.
#pragma once

#include <vector>

#include "hemocell_adapter/settings/setting.h"

namespace packmesh::hemocell {

/// All settings, in the order of the help.
const std::vector<Setting>& settingsTable();

/// The option that states a key, as messages name it; of keys without option the key.
std::string optionOf(const std::string& key);

/// Where a key was stated, with which messages begin: "config.xml:12: <walls>", "option '--walls'".
std::string whereStated(const Request& request, const std::string& key);

/// Refuses a value that is stated. @throws InputError if a section states it, else UsageError
[[noreturn]] void refuseStated(const Request& request, const std::string& key, const std::string& reason);

/// @throws UsageError for settings that exclude each other, or the lumen
void requireConsistent(const Request& request);

}  // namespace packmesh::hemocell

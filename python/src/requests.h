// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What Python asks for: a dict as a request, arrays as numbers, names of arguments in messages.
#pragma once

#include <pybind11/numpy.h>

#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/session/in_memory.h"
#include "hemocell_adapter/settings/request.h"

/// Of a dict with what JSON would have (request_json.h), and numbers of NumPy where a file may be. Needs
/// Python's lock. @throws UsageError
packmesh::hemocell::Request requestOf(const pybind11::dict& stated);

/// A request as such a dict; {"given": ...} stands for numbers.
pybind11::object dictOf(const packmesh::hemocell::Request& request);

/// The words of a command that states a request; None if numbers are given, which no command has.
pybind11::object wordsIn(const packmesh::hemocell::Request& request);

/// Numbers that a request takes in place of a file.
struct PythonNumbers {
  std::shared_ptr<const packmesh::hemocell::Given> given;
};

/// @param setting, of it, with which messages begin
PythonNumbers numbersOf(const std::string& setting, const std::string& of,
                        std::vector<packmesh::StateTable> tables);

void addRequests(pybind11::module_& module);

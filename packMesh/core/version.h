// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Version of packMesh.
#pragma once

namespace packmesh {

/// Version number, e.g. "1.0.0".
const char* version();

/// Abbreviated git commit the library was built from; "unknown" outside a git checkout.
const char* gitHash();

/// The folder where programs that others start are installed, unless another prefix is chosen at
/// installation.
const char* installedHelpers();

}  // namespace packmesh

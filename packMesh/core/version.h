// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which packMesh this is.
#pragma once

namespace packmesh {

/// Version, e.g. "0.1.0".
const char* version();

/// Abbreviated git commit the library was configured from, "unknown" outside a git checkout.
const char* gitHash();

}  // namespace packmesh

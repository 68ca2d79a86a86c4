// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How a packing is sought.
#pragma once

#include <optional>

#include "packMesh/cat/cat_settings.h"

namespace packmesh {

struct Method {
  enum Kind {
    relaxation,  ///< full-size cells are placed at random and pushed apart
    cat,         ///< small cells grow in the cells of the chordal axis transform (thesis chapter 3)
  };
  Kind kind = relaxation;

  // The rest is of `cat`.
  PlaneSource planeSource = PlaneSource::chords;
  GrowthSettings growth = {};
  /// If growth does not bring all cells to full size, and if there is a reserve, escape from local maxima.
  std::optional<EscapeSettings> escape = {};
};

}  // namespace packmesh

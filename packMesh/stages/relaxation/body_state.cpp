// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/relaxation/body_state.h"

namespace packmesh {

BodyState stateOf(const Body& body) {
  BodyState state{};
  for (int k = 0; k < 3; ++k) state.position[k] = body.position[k];
  for (int k = 0; k < 4; ++k) state.orientation[k] = body.orientation.coeffs()[k];
  state.scale = body.scale;
  state.extraWallClearance = body.extraWallClearance;
  state.overlap = body.overlap;
  state.id = body.id;
  state.species = body.species;
  state.block = body.block;
  state.deepInWall = body.deepInWall;
  return state;
}

Body bodyOf(const BodyState& state) {
  Body body;
  for (int k = 0; k < 3; ++k) body.position[k] = state.position[k];
  for (int k = 0; k < 4; ++k) body.orientation.coeffs()[k] = state.orientation[k];
  body.rotation = body.orientation.toRotationMatrix();
  body.scale = state.scale;
  body.extraWallClearance = state.extraWallClearance;
  body.overlap = state.overlap;
  body.id = state.id;
  body.species = state.species;
  body.block = state.block;
  body.deepInWall = state.deepInWall;
  return body;
}

}  // namespace packmesh

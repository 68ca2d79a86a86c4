// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/body_state.h"

namespace packmesh {

PlainPose PlainPose::of(const Body& body) {
  PlainPose pose;
  Eigen::Map<Vec3>(pose.position) = body.position;
  Eigen::Map<Eigen::Vector4d>(pose.orientation) = body.orientation.coeffs();
  return pose;
}

void PlainPose::giveTo(Body& body) const {
  body.position = Eigen::Map<const Vec3>(position);
  body.orientation.coeffs() = Eigen::Map<const Eigen::Vector4d>(orientation);
  body.rotation = body.orientation.toRotationMatrix();
}

BodyState stateOf(const Body& body) {
  BodyState state{};
  state.pose = PlainPose::of(body);
  state.scale = body.scale;
  state.extraWallClearance = body.extraWallClearance;
  state.overlap = body.overlap;
  state.moved = body.moved;
  state.stepTaken = body.stepTaken;
  state.id = body.id;
  state.species = body.species;
  state.block = body.block;
  state.deepInWall = body.deepInWall;
  state.touched = body.touched;
  state.frozen = body.frozen;
  return state;
}

Body bodyOf(const BodyState& state) {
  Body body;
  state.pose.giveTo(body);
  body.scale = state.scale;
  body.extraWallClearance = state.extraWallClearance;
  body.overlap = state.overlap;
  body.moved = state.moved;
  body.stepTaken = state.stepTaken;
  body.id = state.id;
  body.species = state.species;
  body.block = state.block;
  body.deepInWall = state.deepInWall;
  body.touched = state.touched;
  body.frozen = state.frozen;
  return body;
}

std::vector<BodyState> statesOf(const std::vector<Body>& bodies) {
  std::vector<BodyState> states;
  states.reserve(bodies.size());
  for (const Body& body : bodies) states.push_back(stateOf(body));
  return states;
}

std::vector<Body> bodiesOf(const std::vector<BodyState>& states) {
  std::vector<Body> bodies;
  bodies.reserve(states.size());
  for (const BodyState& state : states) bodies.push_back(bodyOf(state));
  return bodies;
}

}  // namespace packmesh

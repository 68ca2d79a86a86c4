// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reference from a point to a face that constrains it.
#pragma once

namespace packmesh {

/// Reference from a point to a face, with the side that the point is on.
class FaceUse {
 public:
  FaceUse() = default;
  FaceUse(int face, bool second) : code_(second ? ~face : face) {}
  int face() const { return code_ < 0 ? ~code_ : code_; }
  double sign() const {
    return code_ < 0 ? -1.0 : 1.0;
  }  ///< times the face's normal points away from the point

 private:
  int code_;
};

}  // namespace packmesh

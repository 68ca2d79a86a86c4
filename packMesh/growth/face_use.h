// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file That a point lies on one side of a face.
#pragma once

namespace packmesh {

/// That a point lies on one side of a face.
class FaceUse {
 public:
  FaceUse() = default;
  FaceUse(int face, bool second) : code_(second ? ~face : face) {}
  int face() const { return code_ < 0 ? ~code_ : code_; }
  double sign() const {
    return code_ < 0 ? -1.0 : 1.0;
  }  ///< times the face's normal leads away from the point

 private:
  int code_;
};

}  // namespace packmesh

// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Suppresses HDF5's error messages. Internal to packMesh.
#pragma once

#include <hdf5.h>

namespace packmesh {

/// HDF5 prints its errors unless told not to; this suppresses them during its lifetime.
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

}  // namespace packmesh

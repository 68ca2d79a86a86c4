// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HDF5 without its messages. Internal to packMesh.
#pragma once

#include <hdf5.h>

namespace packmesh {

/// HDF5 prints its errors unless told not to.
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

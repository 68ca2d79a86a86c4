// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Owner of an HDF5 identifier. Internal to packMesh.
#pragma once

#include <hdf5.h>

#include <utility>

namespace packmesh {

/// Owns an HDF5 identifier and closes it on destruction.
class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
  ~Hdf5Handle() { close(); }
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;

  operator hid_t() const { return id_; }
  bool good() const { return id_ >= 0; }
  bool close() {
    const bool closed = id_ < 0 || closer_(id_) >= 0;
    id_ = -1;
    return closed;
  }
  /// Gives the identifier away.
  hid_t release() { return std::exchange(id_, H5I_INVALID_HID); }

 private:
  hid_t id_;
  herr_t (*closer_)(hid_t);
};

}  // namespace packmesh

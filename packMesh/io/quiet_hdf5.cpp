// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/quiet_hdf5.h"

namespace packmesh {

QuietHdf5::QuietHdf5() {
  H5dont_atexit();  // files are closed by then; for damaged files it would print errors
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
QuietHdf5::~QuietHdf5() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

}  // namespace packmesh

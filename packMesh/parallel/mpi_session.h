// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Initialisation and finalisation of MPI.
#pragma once

namespace packmesh {

/// Initialises MPI on construction and finalises it on destruction. One per program.
class MpiSession {
 public:
  MpiSession();
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
};

/// Whether a rank may have threads of which one uses MPI: whoever initialised MPI, this program or its host,
/// asked for that and was given it. Pre: MPI is initialised
bool mpiPermitsThreads();

}  // namespace packmesh

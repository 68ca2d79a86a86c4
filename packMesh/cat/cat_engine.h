// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The engine of --method cat: cells grow from a small scale to full size (thesis chapter 3).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/cat_settings.h"
#include "packMesh/cat/escape.h"
#include "packMesh/cat/growth.h"
#include "packMesh/packing/engine.h"

namespace packmesh {

class CatStatistics : public EngineStatistics {
 public:
  GrowthStatistics growth;
  std::optional<TetrahedraSums> tetrahedra;  ///< of PlaneSource::catFaces, of all ranks
  std::vector<EscapePhase> escape;           ///< where local maxima were escaped

  std::int64_t iterations() const override { return growth.iterations; }
  std::vector<std::string> lines(const Statistics& all) const override;
  std::string json() const override;
};

/// What growth continues from.
struct CatState final : EngineState {
  std::int64_t attempt = 0, done = 0;  ///< iterations
  GrowthProgress at;
  std::vector<BodyState> best;  ///< of earlier attempts

  std::int64_t iterations() const override { return done; }
  void write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>& cells) const override;
};

/// Places the initial cells and grows them, from several random starts if they are few, and escapes from
/// local maxima if the settings request it.
class CatEngine : public Engine {
 public:
  CatEngine() = default;
  explicit CatEngine(CatSettings of) : settings(std::move(of)) {}

  CatSettings settings;

  StageInFiles stage() const override { return {3, "growth"}; }
  std::shared_ptr<const EngineState> readState(const Hdf5Reader& in, const PackingProblem& problem,
                                               std::int64_t first,
                                               std::vector<BodyState>& cells) const override;
  void validate(const PackingProblem& problem) const override;
  void addTo(Digest& digest) const override;
  std::shared_ptr<EngineStatistics> statistics(std::int64_t iterations) const override;
  std::unique_ptr<EngineStage> begin(const PackingProblem& problem, RunControl& control,
                                     Statistics& statistics, std::function<void()> keep) const override;
  std::shared_ptr<const Engine> forTrials() const override;
  bool canExceedTrials() const override { return settings.escape.has_value(); }
};

}  // namespace packmesh

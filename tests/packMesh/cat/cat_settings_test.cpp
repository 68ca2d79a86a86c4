// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_settings.h"

#include "packMesh/core/error.h"
#include "tests/support/catch.h"

using namespace packmesh;

namespace {

template <class Change>
std::string refusal(Change&& change) {
  GrowthSettings settings;
  change(settings);
  return test::messageOf<InputError>([&] { validate(settings); });
}

}  // namespace

TEST_CASE("The default growth settings and those of the thesis are valid") {
  CHECK_NOTHROW(validate(GrowthSettings()));
  GrowthSettings thesis;
  thesis.barriers = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0};
  thesis.rotationBound = 0.2617993877991494;
  thesis.translationBound = 1.0;
  thesis.padding = 1.0;
  thesis.alpha = 0.05;
  thesis.beta = 0.1;
  thesis.centring = false;
  thesis.shaking = 0.0;
  thesis.relaxationSweeps = 0;
  CHECK_NOTHROW(validate(thesis));
}

TEST_CASE("Growth settings out of range are named") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  using S = GrowthSettings;
  for (const double wrong : {0.0, -1.0, 1.5, nan}) {
    CAPTURE(wrong);
    CHECK_THAT(refusal([&](S& s) { s.initialScale = wrong; }), Contains("initial scale"));
    CHECK_THAT(refusal([&](S& s) { s.alpha = wrong; }), Contains("alpha"));
    CHECK_THAT(refusal([&](S& s) { s.barriers = {wrong, 1.0}; }), Contains("barriers"));
  }
  for (const double wrong : {0.0, -1.0, 1e300, nan}) {
    CAPTURE(wrong);
    CHECK_THAT(refusal([&](S& s) { s.rotationBound = wrong; }), Contains("rotation bound"));
    CHECK_THAT(refusal([&](S& s) { s.translationBound = wrong; }), Contains("translation bound"));
    CHECK_THAT(refusal([&](S& s) { s.beta = wrong; }), Contains("beta"));
  }
  for (const double wrong : {-1e-9, 1e300, nan}) {
    CAPTURE(wrong);
    CHECK_THAT(refusal([&](S& s) { s.padding = wrong; }), Contains("padding"));
    CHECK_THAT(refusal([&](S& s) { s.shaking = wrong; }), Contains("shaking"));
  }
  CHECK_THAT(refusal([](S& s) { s.stalledGrowth = -0.1; }), Contains("stalled"));
  CHECK_THAT(refusal([](S& s) { s.barriers = {}; }), Contains("last barrier"));
  CHECK_THAT(refusal([](S& s) { s.barriers = {0.5}; }), Contains("last barrier"));
  CHECK_THAT(refusal([](S& s) { s.barriers = {0.5, 0.5, 1.0}; }), Contains("must increase"));
  CHECK_THAT(refusal([](S& s) { s.barriers = {1.0, 0.5, 1.0}; }), Contains("must increase"));
  CHECK_THAT(refusal([](S& s) { s.maxIterations = 0; }), Contains("iteration"));
  CHECK_THAT(refusal([](S& s) { s.linearisations = 0; }), Contains("linearised"));
  CHECK_THAT(refusal([](S& s) { s.patience = 0; }), Contains("patience"));
  CHECK_THAT(refusal([](S& s) { s.relaxationSweeps = -1; }), Contains("sweeps"));
  CHECK_THAT(refusal([](S& s) { s.giveUpAfter = -1; }), Contains("gives up"));
  CHECK_THAT(refusal([](S& s) { s.attempts = 0; }), Contains("attempt"));
}

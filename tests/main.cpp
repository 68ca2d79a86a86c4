// SPDX-License-Identifier: AGPL-3.0-or-later
#define CATCH_CONFIG_MAIN
#include <cfenv>

#include <catch2/catch.hpp>

#ifdef PACKMESH_CHECKS
namespace {

/// Invalid operations and divisions by zero end a test, except those marked [nan], which hand such numbers
/// in.
class Traps : public Catch::TestEventListenerBase {
 public:
  using TestEventListenerBase::TestEventListenerBase;

  void testCaseStarting(const Catch::TestCaseInfo& info) override {
    TestEventListenerBase::testCaseStarting(info);
    for (const std::string& tag : info.lcaseTags)
      if (tag == "nan") return;
    std::feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(FE_INVALID | FE_DIVBYZERO);
  }
  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    fedisableexcept(FE_ALL_EXCEPT);
    TestEventListenerBase::testCaseEnded(stats);
  }
};
CATCH_REGISTER_LISTENER(Traps)

}  // namespace
#endif

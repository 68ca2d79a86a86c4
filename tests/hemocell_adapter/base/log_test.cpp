// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/log.h"

#include <catch2/catch.hpp>
#include <utility>
#include <vector>

using namespace packmesh::hemocell;

TEST_CASE("Messages go to a sink instead of being printed, unless silent", "[log]") {
  std::vector<std::pair<log::Kind, std::string>> told;
  log::setSink([&](log::Kind kind, const std::string& text) { told.emplace_back(kind, text); });
  const log::Level before = log::level();
  log::setLevel(log::Level::verbose);
  log::detail("a");
  log::info("b\x1b[31m");
  log::warning("c");
  log::error("d");
  log::repair("f");
  log::setLevel(log::Level::silent);
  log::error("e");
  log::setLevel(before);
  log::setSink({});
  REQUIRE(told.size() == 5);
  CHECK(told[0] == std::pair(log::Kind::detail, std::string("a")));
  CHECK(told[1].second.find('\x1b') == std::string::npos);
  CHECK(told[2].first == log::Kind::warning);
  CHECK(told[3] == std::pair(log::Kind::error, std::string("d")));
  CHECK(told[4].first == log::Kind::repair);
}

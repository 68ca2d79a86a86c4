// SPDX-License-Identifier: AGPL-3.0-or-later
#include <utility>
#include <vector>

#include "hemocell_adapter/base/messages.h"
#include "tests/support/catch.h"

using namespace packmesh::hemocell;

TEST_CASE("Plain text is UTF-8 without control characters") {
  for (const char* good : {"", "RBC", "µm", "血", "\xF0\x9F\xA9\xB8"}) {
    CHECK(plainText(good) == good);
  }
  CHECK(plainText("a\tb\n") == "a\tb\n");
  const std::pair<std::string, std::string> bad[] = {
      {"a\x01z", "a?z"},       {"\x1b[2J", "?[2J"}, {"\x7f", "?"},
      {"\xff", "?"},           {"\xc0\xaf", "??"},  {"\xe2\x82", "??"},
      {"\xed\xa0\x80", "???"}, {"\xc2\x9b", "??"},  {"\xf4\x90\x80\x80", "????"},
      {"\xe0\x80\xaf", "???"}, {"µ\xc2", "µ?"},     {"a\u202ez", "a???z"},
      {"\u2066", "???"},       {"\ufeffa", "???a"}};
  for (const auto& [text, plain] : bad) {
    INFO(plain);
    CHECK(plainText(text) == plain);
  }
}

TEST_CASE("Overlong names are shortened in the middle") {
  const std::string sensible(400, 'n'), head(150, 'h'), tail(149, 't');
  for (const std::string& text :
       {std::string(), sensible, sensible + ' ' + sensible + '\n' + sensible + '\t'})
    CHECK(withShortenedNames(text) == text);
  CHECK(withShortenedNames("in " + head + std::string(5000, 'x') + tail + ": no such file") ==
        "in " + head + "..." + tail + ": no such file");
  // Characters stay whole.
  std::string greek;
  for (int i = 0; i < 300; ++i) greek += "µ";
  CHECK(plainText(withShortenedNames("a" + greek)) == withShortenedNames("a" + greek));
  CHECK(withShortenedNames("a" + greek).size() < 310);
}

using packmesh::hemocell::durationText;

TEST_CASE("Durations are printed in readable units", "[duration]") {
  CHECK(durationText(0.0) == "0 s");
  CHECK(durationText(0.25) == "0.25 s");
  CHECK(durationText(9.0) == "9 s");
  CHECK(durationText(119.4) == "119 s");
  CHECK(durationText(120.0) == "2 min");
  CHECK(durationText(725.2) == "12 min 5 s");
  CHECK(durationText(7199.9) == "120 min");
  CHECK(durationText(12000.0) == "3 h 20 min");
  CHECK(durationText(172800.0) == "2 days");
  CHECK(durationText(1e9) == "32 years");
  CHECK(durationText(9.2e40) == "more than 1000 years");
}

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

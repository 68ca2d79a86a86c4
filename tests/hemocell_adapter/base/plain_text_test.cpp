// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/plain_text.h"

#include <catch2/catch.hpp>

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

// SPDX-License-Identifier: AGPL-3.0-or-later
#include <array>
#include <optional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using namespace packmesh::hemocell;
namespace fs = std::filesystem;

namespace {

/// What is read from a file: numbers, warnings, or the error.
std::string storyOf(const std::vector<PosLine>& lines, const std::vector<std::string>& warnings) {
  std::string story = formatPosLines(lines);
  for (const std::string& warning : warnings) story += warning + '\n';
  return story;
}

std::string readAlone(const fs::path& file) {
  try {
    std::vector<std::string> warnings;
    const std::vector<PosLine> lines = readPos(file, &warnings);
    return storyOf(lines, warnings);
  } catch (const InputError& error) {
    return error.what();
  }
}

/// On the first rank.
std::string readTogether(const fs::path& file, const Communicator& ranks, const Threads& threads) {
  try {
    std::vector<std::string> warnings;
    const PosShare share = readPosShare(file, ranks, threads, &warnings);
    CHECK(share.first == ranks.sumBefore({std::int64_t(share.lines.size())}).front());
    CHECK(share.all == ranks.sum(std::int64_t(share.lines.size())));
    std::vector<PosLine> all;
    for (const auto& line : ranks.gatherAll([&] {
           std::vector<std::array<double, 6>> own;
           for (const PosLine& l : share.lines)
             own.push_back(
                 {l.position[0], l.position[1], l.position[2], l.angles[0], l.angles[1], l.angles[2]});
           return own;
         }()))
      all.push_back({{line[0], line[1], line[2]}, {line[3], line[4], line[5]}});
    return storyOf(all, warnings);
  } catch (const AgreedFailure& failure) {
    return failure.what();
  } catch (const InputError& error) {  // of a single rank
    return error.what();
  }
}

/// A number of lines whose lengths differ.
std::string lines(int count, const std::string& end = "\n") {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += std::to_string(i % 997) + " 2 " + std::to_string(i % 90 * i % 977) + " 4 5 " +
            std::string(i % 5 + 1, '1') + end;
  return text;
}

std::string without(std::string text, std::size_t fromEnd) {
  text.resize(text.size() - fromEnd);
  return text;
}

}  // namespace

TEST_CASE("Several ranks and threads read a .pos file as one does, with the same errors", "[mpi][pos]") {
  const Communicator ranks = Communicator::world();
  std::optional<test::TemporaryFolder> folder;
  if (ranks.rank() == 0) folder.emplace();
  const fs::path file = fs::path(ranks.broadcast(folder ? folder->path().string() : "", 0)) / "RBC.pos";
  std::vector<std::string> texts = {
      "",
      "\n",
      " \r\n\t\n",
      "0\n",
      "0",
      "1\n1 2 3 4 5 6",
      "x\n" + lines(3),
      "\xEF\xBB\xBF"
      "3\n" +
          lines(3),
      "30\n" + lines(30),
      without("30\n" + lines(30), 1),
      "30\r\n" + lines(30, "\r\n"),
      without("30\r\n" + lines(30, "\r\n"), 2),
      "31\n" + lines(30),
      "20\n" + lines(30),
      "0\n" + lines(30),
      "20\n" + lines(20) + "no cell\n\n" + lines(5),
      "30\n\n" + lines(30, "\n\n\n") + "\n\n",
      "30\n" + std::string(200, '\n') + lines(15) + std::string(300, '\n') + lines(15) +
          std::string(99, '\n'),
      "30\n" + lines(10) + " 1\t2 3 4 5 6 \n" + lines(9) + "1  2 3 4 5 6\r\n" + lines(9),
      "30\n" + lines(10) + "# comment\n" + lines(20),
      "30\n" + lines(10) + "1 2 3 4 5\n" + lines(9) + "1 2 3 4 5 nan\n" + lines(10),
      "30\n" + lines(29) + "1 2 3 4 5 1e300\n",
      "2\n" + std::string(500, '1') + "\n" + lines(2),
      std::string(2000, ' ') + "3\n" + lines(3),
  };
  for (std::size_t at = 0; at < 40; ++at) texts.push_back("9\n" + lines(9).substr(0, 150 - at));
  for (const std::string& text : texts) {
    CAPTURE(text);
    if (folder) folder->write("RBC.pos", text);
    ranks.any(false);
    const std::string expected = readAlone(file);
    CHECK(readTogether(file, ranks, Threads()) == expected);
    CHECK(readTogether(file, ranks, Threads(3)) == expected);
    ranks.any(false);
  }
  if (folder) folder->write("RBC.pos", "200000\n" + lines(200000));  // several pieces
  ranks.any(false);
  const std::string expected = readAlone(file);
  CHECK(expected.size() > 1000000);
  CHECK((readTogether(file, ranks, Threads(3)) == expected));  // too long to print
  ranks.any(false);
}

TEST_CASE("The parts of a file have each of its lines once", "[pos]") {
  const test::TemporaryFolder folder;
  for (const std::string& text :
       {std::string(), std::string("\n"), std::string("a"), std::string("ab\n\n\ncdefgh\ni\n"), lines(40),
        lines(1), std::string(100000, 'x') + "\n" + lines(2), without(lines(9), 1)}) {
    const fs::path file = folder.write("text", text);
    for (const int parts : {1, 2, 3, 5, 64}) {
      CAPTURE(text.size(), parts);
      std::string all;
      for (int part = 0; part < parts; ++part) {
        const std::string own = linesOf(file, "a text", part, parts);
        CHECK((all.empty() || own.empty() || all.back() == '\n'));
        if (part == 0) CHECK(own.substr(0, own.find('\n')) == text.substr(0, text.find('\n')));
        all += own;
      }
      CHECK((all == text));
    }
  }
}

// SPDX-License-Identifier: AGPL-3.0-or-later
#include <sys/stat.h>

#include <optional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/output/output_plan.h"
#include "packMesh/core/error.h"
#include "tests/support/catch.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
using namespace packmesh::hemocell;
namespace fs = std::filesystem;

namespace {

/// A folder of all ranks.
struct Shared {
  Shared() {
    if (ranks.rank() == 0) folder.emplace();
    path = ranks.broadcast(folder ? folder->path().string() : "", 0);
  }
  ~Shared() { ranks.any(false); }  // no rank uses it any more
  const Communicator ranks = Communicator::world();
  std::optional<test::TemporaryFolder> folder;
  fs::path path;
};

/// What a rank adds: nothing on some.
std::vector<std::string> partsOf(int rank) {
  if (rank % 3 == 1) return {};
  return {std::string(3 * rank + 1, static_cast<char>('a' + rank)), "", std::string(2500000, 'z')};
}

/// Writes a file with a full disk.
std::string failureOf(const Shared& shared, const fs::path& file) {
  const test::FullDisk full;
  std::string message;
  ExitCode code = ExitCode::ok;
  try {
    SharedFiles files(shared.ranks);
    files.begin(file);
    files.append([] { return "head"; });
    files.appendParts({std::string(5000, 'x')});
    files.end();
    files.commit();
  } catch (const AgreedFailure& failure) {
    message = failure.what();
    code = failure.code();
  } catch (const OutputError& error) {  // of a single rank
    message = error.what();
    code = ExitCode::cannotWrite;
  }
  CHECK(code == ExitCode::cannotWrite);
  return message;
}

}  // namespace

TEST_CASE("All ranks write parts of one file, in their order", "[mpi][io]") {
  const Shared shared;
  const fs::path file = shared.path / "RBC.pos";
  if (shared.folder) {
    shared.folder->write("RBC.pos", "old");
    ::chmod(file.c_str(), 0640);
  }
  SharedFiles files(shared.ranks);
  files.makeFolder(shared.path);
  files.begin(file);
  files.append([] { return "head\n"; });
  files.appendParts(partsOf(shared.ranks.rank()));
  files.append([] { return "between\n"; });
  files.appendParts({"rank " + std::to_string(shared.ranks.rank()) + "\n"});
  files.end();
  files.begin(shared.path / "PLT.pos");
  files.append([] { return "0\n"; });
  files.appendParts({});
  files.end();
  if (shared.folder) CHECK(test::readText(file) == "old");
  files.commit();
  if (!shared.folder) return;
  std::string expected = "head\n", ranks;
  for (int r = 0; r < shared.ranks.size(); ++r) {
    for (const std::string& part : partsOf(r)) expected += part;
    ranks += "rank " + std::to_string(r) + "\n";
  }
  CHECK((test::readText(file) == expected + "between\n" + ranks));  // too long to print
  CHECK(test::readText(shared.path / "PLT.pos") == "0\n");
  CHECK(shared.folder->files() == 2);
  struct stat info;
  REQUIRE(::stat(file.c_str(), &info) == 0);
  CHECK((info.st_mode & 0777) == 0640);
}

TEST_CASE("If the file cannot be written, all ranks fail and no file changes", "[mpi][io]") {
  const Shared shared;
  if (shared.folder) shared.folder->write("RBC.pos", "old");
  CHECK_THAT(failureOf(shared, shared.path / "RBC.pos"),
             Contains("RBC.pos: cannot be written: File too large"));
  shared.ranks.any(false);  // the first rank has removed the temporary file
  if (shared.folder) CHECK(shared.folder->files() == 1);
  if (shared.folder) CHECK(test::readText(shared.path / "RBC.pos") == "old");
}

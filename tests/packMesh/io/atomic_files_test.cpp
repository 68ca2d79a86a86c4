// SPDX-License-Identifier: AGPL-3.0-or-later
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include "packMesh/core/error.h"
#include "packMesh/io/atomic_files.h"
#include "tests/support/catch.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

TEST_CASE("Temporary names contain host and process and are never too long", "[io]") {
  const std::filesystem::path name = temporaryName("folder/state.h5", 7, "new");
  CHECK(name.parent_path() == "folder");
  CHECK_THAT(name.filename().string(), StartsWith(".state.h5~") && EndsWith("-7.new") &&
                                           Contains(std::to_string(processNumber())) &&
                                           Contains(hostName().substr(0, 60)));
  CHECK(temporaryName("a", 0, "new") != temporaryName("a", 1, "new"));

  std::string longest;
  while (longest.size() < 250) longest += "血";
  CHECK(temporaryName(longest, 1000, "new").filename().string().size() < 256);
}

TEST_CASE("Temporary files are told from those of targets with similar names", "[io]") {
  const std::string longName(200, 'x');
  const std::vector<std::string> targets = {"run",  "run.h5",       "run.h5.h5",   "run~a",
                                            "run~", longName + "1", longName + "2"};
  for (const std::string& target : targets)
    for (const std::string& other : targets) {
      CAPTURE(target, other);
      CHECK(isTemporaryOf(temporaryName("folder/" + other, 0, "new"), "folder/" + target, "new") ==
            (target == other));
      CHECK((lockName(target) == lockName(other)) == (target == other));
    }
  CHECK_FALSE(isTemporaryOf(temporaryName("run", 0, "old"), "run", "new"));
  CHECK_FALSE(isTemporaryOf(lockName("run"), "run", "new"));
}

namespace fs = std::filesystem;

TEST_CASE("AtomicFiles replaces all files or none", "[io]") {
  const test::TemporaryFolder folder;
  const fs::path a = folder.path() / "RBC.pos", b = folder.path() / "PLT.pos";
  folder.write("RBC.pos", "old");
  ::chmod(a.c_str(), 0640);
  {
    AtomicFiles files;
    files.add(a, "new a");
    files.add(b, "new b");
    CHECK(test::readText(a) == "old");
    CHECK(!fs::exists(b));
  }  // not committed
  CHECK(test::readText(a) == "old");
  CHECK(folder.files() == 1);

  AtomicFiles files;
  files.add(a, "new a");
  files.add(b, std::string(200000, 'b'));
  files.commit();
  CHECK(test::readText(a) == "new a");
  CHECK(test::readText(b) == std::string(200000, 'b'));
  CHECK(folder.files() == 2);
  struct stat info;
  REQUIRE(::stat(a.c_str(), &info) == 0);
  CHECK((info.st_mode & 0777) == 0640);
}

TEST_CASE("AtomicFiles changes nothing if a file cannot be written", "[io]") {
  const test::TemporaryFolder folder;
  const fs::path a = folder.write("RBC.pos", "old");
  SECTION("no such folder") {
    AtomicFiles files;
    files.add(a, "new");
    CHECK_THROWS_WITH(files.add(folder.path() / "none" / "PLT.pos", "x"),
                      Contains("cannot write to the folder"));
  }
  SECTION("a folder in the way") {
    AtomicFiles files;
    CHECK_THROWS_AS(files.add(folder.path(), "x"), OutputError);
  }
  SECTION("twice the same") {
    AtomicFiles files;
    files.add(a, "new");
    CHECK_THROWS_WITH(files.add(a, "newer"), Contains("two outputs"));
  }
  SECTION("a full disk") {
    std::string message;
    {
      const test::FullDisk full;
      AtomicFiles files;
      try {
        files.add(a, "new");
        files.add(folder.path() / "PLT.pos", std::string(5000, 'x'));
      } catch (const OutputError& error) {
        message = error.what();
      }
    }
    CHECK_THAT(message, Contains("PLT.pos: cannot be written"));
  }
  SECTION("a target that turns into a folder before the commit") {
    AtomicFiles files;
    files.add(a, "new");
    files.add(folder.path() / "PLT.pos", "x");
    files.add(folder.path() / "WBC.pos", "x");
    fs::create_directory(folder.path() / "WBC.pos");
    CHECK_THROWS_AS(files.commit(), OutputError);
    fs::remove(folder.path() / "WBC.pos");
  }
  CHECK(test::readText(a) == "old");
  CHECK(folder.files() == 1);
}

TEST_CASE("AtomicFiles writes through a symbolic link", "[io]") {
  const test::TemporaryFolder folder;
  const fs::path real = folder.write("real.pos", "old"), link = folder.path() / "RBC.pos";
  fs::create_symlink("real.pos", link);
  AtomicFiles files;
  files.add(link, "new");
  files.commit();
  CHECK(fs::is_symlink(link));
  CHECK(test::readText(real) == "new");
}

TEST_CASE("No new file is beside an old one at any time, and what is left over is put aside", "[io]") {
  const test::TemporaryFolder folder;
  const fs::path red = folder.write("RBC.pos", "old"), platelets = folder.write("PLT.pos", "old");
  const fs::path white = folder.write("WBC.pos", "old white");
  const int watch = ::inotify_init1(IN_NONBLOCK);
  REQUIRE(watch >= 0);
  REQUIRE(::inotify_add_watch(watch, folder.path().c_str(), IN_MOVE | IN_DELETE) >= 0);
  AtomicFiles files, others;
  files.add(red, "new");
  others.add(platelets, "new");
  files.putAside(white, white.string() + ".old");
  files.take(others);
  files.commit();
  std::vector<char> events(1 << 16);
  const ssize_t size = ::read(watch, events.data(), events.size());
  ::close(watch);
  REQUIRE(size > 0);
  std::set<std::string> oldOnes = {"RBC.pos", "PLT.pos", "WBC.pos"};
  int newOnes = 0;
  for (ssize_t at = 0; at < size;) {
    struct inotify_event event;
    std::memcpy(&event, events.data() + at, sizeof event);
    const std::string name = events.data() + at + sizeof event;
    if (event.mask & (IN_MOVED_FROM | IN_DELETE)) oldOnes.erase(name);
    if ((event.mask & IN_MOVED_TO) && (name == "RBC.pos" || name == "PLT.pos")) {
      ++newOnes;
      CHECK(oldOnes.empty());
    }
    at += ssize_t(sizeof event) + event.len;
  }
  CHECK(newOnes == 2);
  CHECK(test::readText(red) + test::readText(platelets) == "newnew");
  CHECK_FALSE(fs::exists(white));
  CHECK(test::readText(white.string() + ".old") == "old white");
  CHECK(folder.files() == 3);
}

TEST_CASE("What was put aside is put back if the new files cannot be renamed", "[io]") {
  const test::TemporaryFolder folder;
  const fs::path white = folder.write("WBC.pos", "old");
  AtomicFiles files;
  files.putAside(white, white.string() + ".old");
  files.add(folder.path() / "RBC.pos", "new");
  fs::create_directory(folder.path() / "RBC.pos");
  CHECK_THROWS_AS(files.commit(), OutputError);
  fs::remove(folder.path() / "RBC.pos");
  CHECK(test::readText(white) == "old");
  CHECK_FALSE(fs::exists(white.string() + ".old"));
}

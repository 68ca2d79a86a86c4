// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <system_error>
#include <thread>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "packMesh/core/temporary_name.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isSameFile(int descriptor, const fs::path& path) {
  struct stat open, there;
  return ::fstat(descriptor, &open) == 0 && ::stat(path.c_str(), &there) == 0 &&
         open.st_dev == there.st_dev && open.st_ino == there.st_ino;
}

/// What the holder of a lock wrote into its file.
std::string holderIn(const fs::path& path) {
  std::ifstream in(path);
  std::string holder;
  return std::getline(in, holder) && !holder.empty() ? " (" + holder + ")" : "";
}

/// Time to wait for a lock [s]: ranks of a run that was stopped may end slightly later than the run.
constexpr std::chrono::seconds patience(2);
constexpr std::chrono::milliseconds pause(50);

void tellHolder(int descriptor) {
  const std::string holder = fmt::format("process {} on {}\n", processNumber(), hostName());
  if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, holder.data(), holder.size(), 0) < 0)
    log::detail("The lock file cannot be written: " + std::string(std::strerror(errno)));
}

/// Removes what runs that were killed have left in a folder.
template <class Chosen>
void removeTemporary(const fs::path& folder, const Chosen& chosen) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, ignored))
    if (chosen(entry.path())) fs::remove(entry.path(), ignored);
}

}  // namespace

/// @return false if another process has the lock @throws OutputError
bool RunLock::tryToTake(const fs::path& path) {
  for (;;) {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (descriptor < 0)
      throw OutputError(
          fmt::format("{}: cannot be opened as a lock: {}", path.string(), std::strerror(errno)));
    int failed = 0;
    do {
      failed = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 ? errno : 0;
    } while (failed == EINTR);
    if (failed == EWOULDBLOCK) {
      ::close(descriptor);
      return false;
    }
    if (failed != 0) log::detail(fmt::format("{}: the file system has no locks", path.string()));
    // The previous holder may have ended and removed the file since it was opened.
    if (failed == 0 && !isSameFile(descriptor, path)) {
      ::close(descriptor);
      continue;
    }
    path_ = path;
    descriptor_ = descriptor;
    return true;
  }
}

void RunLock::take(const fs::path& path, const fs::path& target, const char* kind, const char* advice) {
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!tryToTake(path)) {
    if (std::chrono::steady_clock::now() >= until) {
      std::error_code ignored;
      throw OutputError(fmt::format("{}: another packMesh is writing {}{}; wait until it has ended, or {}",
                                    fs::absolute(target, ignored).lexically_normal().string(), kind,
                                    holderIn(path), advice));
    }
    std::this_thread::sleep_for(pause);
  }
  tellHolder(descriptor_);
}

void RunLock::makeFolder(const fs::path& folder) {
  std::vector<fs::path> missing;  // innermost first
  std::error_code error;
  for (fs::path one = folder; !one.empty() && !fs::exists(one, error); one = one.parent_path())
    if (one.has_filename()) missing.push_back(one);
  for (auto one = missing.rbegin(); one != missing.rend(); ++one) {
    if (!fs::create_directory(*one, error)) break;
    made_.push_back(*one);
  }
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    throw OutputError(fmt::format("{}: the folder cannot be created: {}", folder.string(), error.message()));
}

RunLock RunLock::ofFolder(const fs::path& folder) {
  RunLock lock;
  lock.makeFolder(folder);
  lock.take(folder / ".packMesh.lock", folder, "into this folder", "write into another one (--output-dir)");
  removeTemporary(folder, [](const fs::path& file) { return isAbandoned(file, "new"); });
  return lock;
}

RunLock RunLock::ofFile(const fs::path& file) {
  RunLock lock;
  lock.makeFolder(file.parent_path());
  lock.take(lockName(file), file, "it", "write another one (--state)");
  removeTemporary(file.parent_path(), [&](const fs::path& one) {
    return isTemporaryOf(one, file, "new") || isTemporaryOf(one, checkpointOf(file), "new");
  });
  return lock;
}

RunLock::RunLock(RunLock&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      made_(std::exchange(other.made_, {})) {}

RunLock::~RunLock() {
  if (descriptor_ >= 0) {
    ::unlink(path_.c_str());  // while it is locked: no other process can hold a lock on a file without a name
    ::close(descriptor_);
  }
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) ::rmdir(folder->c_str());
}

}  // namespace packmesh::hemocell

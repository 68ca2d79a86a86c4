// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/atomic_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>

#include "packMesh/core/error.h"

namespace packmesh {
namespace {

constexpr std::size_t longestName = 100, longestHost = 60;  // [bytes]; the whole name stays below 255

/// Common beginning of the names of all temporary files of `target`. What follows it has no '~', so that no
/// file is taken for one of a target with a shorter name.
std::string prefixOf(const std::filesystem::path& target) {
  const std::string name = target.filename().string();
  if (name.size() <= longestName) return "." + name + "~";
  return fmt::format(".{:016x}~", XXH3_64bits(name.data(), name.size()));
}

}  // namespace

std::string hostName() {
  char name[256] = {};
  if (::gethostname(name, sizeof name - 1) != 0 || name[0] == '\0') return "localhost";
  std::string host = name;
  std::replace_if(
      host.begin(), host.end(), [](char c) { return c == '/' || c == '~'; }, '_');
  return host;
}

long processNumber() {
  return ::getpid();
}

std::filesystem::path temporaryName(const std::filesystem::path& target, int number,
                                    const std::string& kind) {
  return target.parent_path() / (prefixOf(target) + hostName().substr(0, longestHost) + "." +
                                 std::to_string(processNumber()) + "-" + std::to_string(number) + "." + kind);
}

bool isTemporaryOf(const std::filesystem::path& file, const std::filesystem::path& target,
                   const std::string& kind) {
  const std::string name = file.filename().string(), prefix = prefixOf(target);
  return name.compare(0, prefix.size(), prefix) == 0 && name.find('~', prefix.size()) == name.npos &&
         file.extension() == "." + kind;
}

bool isAbandoned(const std::filesystem::path& file, const std::string& kind) {
  const std::string name = file.filename().string(), host = "~" + hostName().substr(0, longestHost) + ".";
  const std::size_t tilde = name.rfind('~');
  if (name.empty() || name[0] != '.' || tilde == name.npos || file.extension() != "." + kind ||
      name.compare(tilde, host.size(), host) != 0)
    return false;
  const char* const number = name.c_str() + tilde + host.size();
  char* end = nullptr;
  const long process = std::strtol(number, &end, 10);
  return end != number && *end == '-' && process > 0 && ::kill(static_cast<pid_t>(process), 0) != 0 &&
         errno == ESRCH;
}

std::filesystem::path lockName(const std::filesystem::path& target) {
  return target.parent_path() / (prefixOf(target) + "lock");
}

namespace {

namespace fs = std::filesystem;

/// A new file next to `target`.
struct NewFile {
  NewFile(const fs::path& target, const char* kind) {
    const fs::path folder = target.parent_path();
    for (int attempt = 0;; ++attempt) {
      path = temporaryName(target, attempt, kind);
      descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor >= 0) return;
      if (errno != EEXIST || attempt > 1000)
        failToWrite(target, "cannot write to the folder '" + (folder.empty() ? "." : folder.string()) + "'",
                    errno);
    }
  }
  fs::path path;
  int descriptor = -1;
};

/// Makes the renames in `folder` durable. Errors are ignored: some file systems do not support this.
void flushFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

/// Gives the present content of `target` another name; returns an empty path if there is no target. If the
/// file system has no hard links, the first name is gone.
fs::path keepAside(const fs::path& target) {
  struct stat info;
  if (::lstat(target.c_str(), &info) != 0) return {};
  if (S_ISDIR(info.st_mode)) failToWrite(target, "cannot be replaced", EISDIR);
  const NewFile backup(target, "old");
  ::close(backup.descriptor);
  ::unlink(backup.path.c_str());
  if (::link(target.c_str(), backup.path.c_str()) != 0 && ::rename(target.c_str(), backup.path.c_str()) != 0)
    failToWrite(target, "cannot be replaced", errno);
  return backup.path;
}

/// Gives a content its name again. If that is impossible, the backup stays: it is the only copy.
void putBack(const fs::path& backup, const fs::path& target) {
  bool isBack = ::rename(backup.c_str(), target.c_str()) == 0;
  if (!isBack) {  // a disk that fails may still take links
    ::unlink(target.c_str());
    isBack = ::link(backup.c_str(), target.c_str()) == 0;
  }
  // rename() between two names of the same file does nothing: remove the second name.
  if (isBack) ::unlink(backup.c_str());
}

}  // namespace

void failToWrite(const fs::path& target, const std::string& what, int error) {
  throw OutputError(target.string() + ": " + what +
                    (error != 0 ? std::string(": ") + std::strerror(error) : ""));
}

void requireReplaceable(const fs::path& target) {
  struct stat info;
  if (::stat(target.c_str(), &info) != 0) {
    if (errno == ENOENT) return;
    failToWrite(target, "cannot be written", errno);
  }
  if (!S_ISREG(info.st_mode)) failToWrite(target, "is not a regular file and cannot be replaced", 0);
  if (::access(target.c_str(), W_OK) != 0) failToWrite(target, "exists and cannot be written", errno);
}

AtomicFiles::~AtomicFiles() {
  if (descriptor_ >= 0) ::close(descriptor_);
  for (const Entry& entry : entries_)
    if (!entry.temporary.empty()) ::unlink(entry.temporary.c_str());
}

void AtomicFiles::begin(const fs::path& requested) {
  std::error_code ignored;
  fs::path target = requested;
  if (fs::is_symlink(target, ignored) && fs::exists(target, ignored)) target = fs::canonical(target, ignored);
  requireReplaceable(target);
  struct stat info;
  const bool exists = ::stat(target.c_str(), &info) == 0;
  for (const Entry& entry : entries_)
    if (entry.target == target) failToWrite(target, "is named for two outputs", 0);

  entries_.reserve(entries_.size() + 1);
  const NewFile file(target, "new");
  entries_.push_back(
      {target, file.path, exists ? std::optional<mode_t>(info.st_mode & 07777) : std::nullopt});
  descriptor_ = file.descriptor;
  size_ = 0;
}

/// Not by MPI: Open MPI's MPI_File_write_at_all() reports success if the disk is full (4.1.4).
void AtomicFiles::write(std::int64_t position, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), static_cast<off_t>(position));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) failToWrite(target(), "cannot be written", written < 0 ? errno : ENOSPC);
    text.remove_prefix(static_cast<std::size_t>(written));
    position += written;
    size_ = std::max(size_, position);
  }
}

void AtomicFiles::end() {
  const Entry& entry = entries_.back();
  if (entry.mode && ::fchmod(descriptor_, *entry.mode) != 0)
    failToWrite(entry.target, "its permissions cannot be kept", errno);
  // Some file systems report only now that they are full. EINVAL: the file system does not support flushing.
  if (::fsync(descriptor_) != 0 && errno != EINVAL)
    failToWrite(entry.target, "cannot be flushed to the disk", errno);
  if (::close(std::exchange(descriptor_, -1)) != 0) failToWrite(entry.target, "cannot be written", errno);
}

void AtomicFiles::putAside(const fs::path& file, const fs::path& as) {
  std::error_code ignored;
  if (fs::is_directory(as, ignored)) failToWrite(as, "cannot be replaced", EISDIR);
  entries_.push_back({file, {}, {}, as});
}

void AtomicFiles::take(AtomicFiles& others) {
  for (Entry& other : others.entries_) {
    for (const Entry& entry : entries_)
      if (entry.target == other.target) failToWrite(other.target, "is named for two outputs", 0);
    entries_.push_back(other);
    other.temporary.clear();
  }
  others.entries_.clear();
}

void AtomicFiles::commit() {
  std::vector<fs::path> backups(entries_.size());
  std::size_t done = 0;
  const auto undo = [&] {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (!backups[i].empty())
        putBack(backups[i], entries_[i].target);
      else if (i < done && entries_[i].aside.empty())
        ::unlink(entries_[i].target.c_str());
    }
  };
  try {
    for (std::size_t i = 0; i < entries_.size(); ++i) backups[i] = keepAside(entries_[i].target);
    const bool single = entries_.size() == 1 && entries_.front().aside.empty();  // is replaced in place
    for (std::size_t i = 0; i < entries_.size() && !single; ++i)
      if (!backups[i].empty() && ::unlink(entries_[i].target.c_str()) != 0 && errno != ENOENT)
        failToWrite(entries_[i].target, "cannot be replaced", errno);
    for (; done < entries_.size(); ++done) {
      const Entry& entry = entries_[done];
      if (entry.aside.empty() && ::rename(entry.temporary.c_str(), entry.target.c_str()) != 0)
        failToWrite(entry.target, "cannot be renamed to its final name", errno);
    }
  } catch (...) {
    undo();
    throw;
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (backups[i].empty()) continue;
    const fs::path& aside = entries_[i].aside;
    if (aside.empty())
      ::unlink(backups[i].c_str());
    else
      ::rename(backups[i].c_str(), aside.c_str());  // if that fails, the backup stays: it is the only copy
  }
  for (const Entry& entry : entries_) flushFolder(entry.target.parent_path());
  entries_.clear();
}

}  // namespace packmesh

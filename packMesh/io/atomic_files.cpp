// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/atomic_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <system_error>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/temporary_name.h"

namespace packmesh {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& target, const std::string& what, int error) {
  throw OutputError(target.string() + ": " + what +
                    (error != 0 ? std::string(": ") + std::strerror(error) : ""));
}

/// A new file next to `target`.
struct NewFile {
  NewFile(const fs::path& target, const char* kind) {
    const fs::path folder = target.parent_path();
    for (int attempt = 0;; ++attempt) {
      path = temporaryName(target, attempt, kind);
      descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor >= 0) return;
      if (errno != EEXIST || attempt > 1000)
        fail(target, "cannot write to the folder '" + (folder.empty() ? "." : folder.string()) + "'", errno);
    }
  }
  fs::path path;
  int descriptor = -1;
};

void writeAll(int descriptor, const std::string& text, const fs::path& target) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = ::write(descriptor, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(target, "cannot be written", written < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(written);
  }
}

/// Makes the renames in `folder` durable. Errors are ignored: some file systems do not support this.
void flushFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

/// Keeps the present content of `target` under another name; returns an empty path if there is no target.
fs::path keepAside(const fs::path& target) {
  struct stat info;
  if (::lstat(target.c_str(), &info) != 0) return {};
  if (S_ISDIR(info.st_mode)) fail(target, "cannot be replaced", EISDIR);
  const NewFile backup(target, "old");
  ::close(backup.descriptor);
  ::unlink(backup.path.c_str());
  // A second name for the same file; if the file system has no hard links, the file is renamed instead.
  if (::link(target.c_str(), backup.path.c_str()) != 0 && ::rename(target.c_str(), backup.path.c_str()) != 0)
    fail(target, "cannot be replaced", errno);
  return backup.path;
}

}  // namespace

void requireReplaceable(const fs::path& target) {
  struct stat info;
  if (::stat(target.c_str(), &info) != 0) {
    if (errno == ENOENT) return;
    fail(target, "cannot be written", errno);
  }
  if (!S_ISREG(info.st_mode)) fail(target, "is not a regular file and cannot be replaced", 0);
  if (::access(target.c_str(), W_OK) != 0) fail(target, "exists and cannot be written", errno);
}

AtomicFiles::~AtomicFiles() {
  if (open_ >= 0) ::close(open_);
  for (const Entry& entry : entries_) ::unlink(entry.temporary.c_str());
}

void AtomicFiles::begin(const fs::path& requested) {
  std::error_code ignored;
  fs::path target = requested;
  if (fs::is_symlink(target, ignored) && fs::exists(target, ignored)) target = fs::canonical(target, ignored);
  requireReplaceable(target);
  struct stat info;
  const bool exists = ::stat(target.c_str(), &info) == 0;
  for (const Entry& entry : entries_)
    if (entry.target == target) fail(target, "is named for two outputs", 0);

  entries_.reserve(entries_.size() + 1);
  parts_.clear();
  const NewFile file(target, "new");
  entries_.push_back({target, file.path});
  open_ = file.descriptor;
  if (exists && ::fchmod(open_, info.st_mode & 07777) != 0)
    fail(target, "its permissions cannot be kept", errno);
}

void AtomicFiles::append(const std::string& text) {
  writeAll(open_, text, entries_.back().target);
  parts_.push_back({text.size(), std::hash<std::string>()(text)});
}

void AtomicFiles::end() {
  const Entry& entry = entries_.back();
  // Some file systems report only now that they are full. EINVAL: the file system does not support flushing.
  if (::fsync(open_) != 0 && errno != EINVAL) fail(entry.target, "cannot be flushed to the disk", errno);
  if (::close(std::exchange(open_, -1)) != 0) fail(entry.target, "cannot be written", errno);
  std::ifstream file(entry.temporary, std::ios::binary);
  std::string text;
  for (const Part& part : parts_) {
    text.resize(part.length);
    if (!file.read(text.data(), static_cast<std::streamsize>(part.length)) ||
        std::hash<std::string>()(text) != part.hash)
      fail(entry.target, "reads back differently from what was written", 0);
  }
  if (file.peek() != std::ifstream::traits_type::eof())
    fail(entry.target, "reads back differently from what was written", 0);
}

void AtomicFiles::commit() {
  std::vector<fs::path> backups(entries_.size());
  std::size_t done = 0;
  const auto putBack = [&] {
    for (std::size_t i = 0; i <= done && i < entries_.size(); ++i) {
      if (!backups[i].empty())
        ::rename(backups[i].c_str(), entries_[i].target.c_str());
      else if (i < done)
        ::unlink(entries_[i].target.c_str());
      // rename() between two names of the same file does nothing: remove the second name.
      if (!backups[i].empty()) ::unlink(backups[i].c_str());
    }
  };
  try {
    for (; done < entries_.size(); ++done) {
      backups[done] = keepAside(entries_[done].target);
      if (::rename(entries_[done].temporary.c_str(), entries_[done].target.c_str()) != 0)
        fail(entries_[done].target, "cannot be renamed to its final name", errno);
    }
  } catch (...) {
    putBack();
    throw;
  }
  for (const fs::path& backup : backups)
    if (!backup.empty()) ::unlink(backup.c_str());
  for (const Entry& entry : entries_) flushFolder(entry.target.parent_path());
  entries_.clear();
}

}  // namespace packmesh

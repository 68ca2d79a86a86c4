// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/checked_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <utility>

#include "packMesh/core/error.h"

namespace packmesh {
namespace {

/// What is read back at a time [bytes].
constexpr std::size_t longestPart = std::size_t{1} << 20;

constexpr const char* differs = "reads back differently from what was written";

}  // namespace

void failToWrite(const std::filesystem::path& target, const std::string& what, int error) {
  throw OutputError(target.string() + ": " + what +
                    (error != 0 ? std::string(": ") + std::strerror(error) : ""));
}

CheckedFile::CheckedFile(const std::filesystem::path& file, std::filesystem::path target)
    : CheckedFile(::open(file.c_str(), O_RDWR | O_CLOEXEC), std::move(target)) {
  if (descriptor_ < 0) failToWrite(target_, "cannot be written", errno);
}

CheckedFile::CheckedFile(int descriptor, std::filesystem::path target)
    : descriptor_(descriptor), target_(std::move(target)) {}

CheckedFile::~CheckedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void CheckedFile::write(std::int64_t position, std::string_view text) {
  for (std::size_t at = 0; at < text.size(); at += longestPart) {
    const std::string_view part = text.substr(at, longestPart);
    parts_.push_back(
        {position + static_cast<std::int64_t>(at), part.size(), std::hash<std::string_view>()(part)});
  }
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = ::pwrite(descriptor_, text.data() + done, text.size() - done,
                                     static_cast<off_t>(position) + static_cast<off_t>(done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) failToWrite(target_, "cannot be written", written < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(written);
  }
}

void CheckedFile::verify() {
  // Some file systems report only now that they are full. EINVAL: the file system does not support flushing.
  if (::fsync(descriptor_) != 0 && errno != EINVAL)
    failToWrite(target_, "cannot be flushed to the disk", errno);
  std::string text;
  for (const Part& part : parts_) {
    text.resize(part.length);
    for (std::size_t done = 0; done < part.length;) {
      const ssize_t got = ::pread(descriptor_, text.data() + done, part.length - done,
                                  static_cast<off_t>(part.position) + static_cast<off_t>(done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) failToWrite(target_, differs, 0);
      done += static_cast<std::size_t>(got);
    }
    if (std::hash<std::string_view>()(text) != part.hash) failToWrite(target_, differs, 0);
  }
}

void CheckedFile::requireSize(std::int64_t size) const {
  struct stat info;
  if (::fstat(descriptor_, &info) != 0 || static_cast<std::int64_t>(info.st_size) != size)
    failToWrite(target_, differs, 0);
}

void CheckedFile::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) failToWrite(target_, "cannot be written", errno);
}

}  // namespace packmesh

// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "packMesh/core/error.h"

namespace packmesh {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void failReading(const fs::path& file, int error) {
  const bool absent = error == ENOENT;
  throw InputError(file.string() + (absent ? ": no such file" : ": cannot be read: ") +
                   (absent ? "" : std::strerror(error)));
}

void requireRegular(const struct stat& info, const fs::path& file, const std::string& expected) {
  const char* kind = S_ISREG(info.st_mode)                              ? nullptr
                     : S_ISDIR(info.st_mode)                            ? "a folder"
                     : S_ISFIFO(info.st_mode) || S_ISSOCK(info.st_mode) ? "a pipe"
                     : S_ISCHR(info.st_mode) || S_ISBLK(info.st_mode)   ? "a device"
                                                                        : "not a regular file";
  if (kind) throw InputError(file.string() + ": is " + kind + ", expected " + expected);
}

/// Closes a file descriptor on destruction.
struct Descriptor {
  explicit Descriptor(int opened) : number(opened) {}
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number;
};

}  // namespace

bool isThere(const fs::path& file) {
  struct stat info;
  return ::stat(file.c_str(), &info) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

void requireFile(const fs::path& file, const std::string& expected) {
  struct stat info;
  if (::stat(file.c_str(), &info) != 0) failReading(file, errno);
  requireRegular(info, file, expected);
}

std::string contentOf(const fs::path& file, const std::string& expected) {
  // Without O_NONBLOCK, opening a pipe would block until another process opens it for writing.
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  const int error = errno;
  struct stat info;
  if (in.number < 0) {
    requireFile(file, expected);  // sockets cannot be opened
    failReading(file, error);
  }
  if (::fstat(in.number, &info) != 0) failReading(file, errno);
  requireRegular(info, file, expected);

  constexpr std::size_t step = std::size_t{1} << 16;
  std::string content;
  for (std::size_t done = 0;;) {
    // One byte more than the expected size, to detect the end; files in /proc and /sys report size 0.
    content.resize(std::max(static_cast<std::size_t>(info.st_size) + 1, done + step));
    const ssize_t got = ::read(in.number, content.data() + done, content.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) failReading(file, errno);
    done += static_cast<std::size_t>(got);
    if (got > 0) continue;
    content.resize(done);
    return content;
  }
}

}  // namespace packmesh

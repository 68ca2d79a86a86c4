// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <optional>
#include <set>
#include <utility>

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

/// A regular file that is open for reading.
struct OpenFile {
  OpenFile(const fs::path& file, const std::string& expected)
      // Without O_NONBLOCK, opening a pipe would block until another process opens it for writing.
      : name(file), number(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {
    const int error = errno;
    if (number < 0) {
      requireFile(file, expected);  // sockets cannot be opened
      failReading(file, error);
    }
    struct stat info;
    try {
      if (::fstat(number, &info) != 0) failReading(file, errno);
      requireRegular(info, file, expected);
    } catch (...) {
      ::close(number);
      throw;
    }
    size = static_cast<std::int64_t>(info.st_size);
    recordInput(file);
  }
  ~OpenFile() { ::close(number); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  /// Appends up to `most` bytes from position `from` on. @return false: there are none
  bool append(std::string& content, std::int64_t from, std::size_t most) const {
    const std::size_t before = content.size();
    content.resize(before + most);
    ssize_t got = -1;
    do {
      got = ::pread(number, content.data() + before, most, static_cast<off_t>(from));
    } while (got < 0 && errno == EINTR);
    if (got < 0) failReading(name, errno);
    content.resize(before + static_cast<std::size_t>(got));
    return got > 0;
  }

  const fs::path& name;
  int number;
  std::int64_t size = 0;  ///< [bytes]; files in /proc and /sys report 0
};

/// Device and number.
using FileId = std::pair<dev_t, ino_t>;

std::optional<FileId> idOf(const fs::path& file) {
  struct stat info;
  if (::stat(file.c_str(), &info) != 0) return {};
  return FileId(info.st_dev, info.st_ino);
}

thread_local std::shared_ptr<InputFiles> current;

/// Bytes that are read at a time where it is not known how many there are.
constexpr std::size_t step = std::size_t{1} << 16;

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
  return linesOf(file, expected, 0, 1);
}

std::string linesOf(const fs::path& file, const std::string& expected, int part, int parts) {
  const OpenFile in(file, expected);
  // The first line that begins at a border or after it comes after the first line feed at border - 1 or
  // after.
  const auto feedFrom = [&](int p) {
    return p == 0 ? -1 : std::max<std::int64_t>(in.size * p / parts - 1, 0);
  };
  const std::int64_t begin = std::max<std::int64_t>(feedFrom(part), 0), end = feedFrom(part + 1);
  const bool last = part + 1 == parts;
  std::string content;
  const auto position = [&] { return begin + static_cast<std::int64_t>(content.size()); };
  // One byte more than the expected size, to detect the end.
  for (bool more = true; more && (last || position() <= end);)
    more = in.append(content, position(),
                     static_cast<std::size_t>(std::max<std::int64_t>(end + 2 - position(), step)));
  if (!last) {
    std::size_t feed = content.find('\n', static_cast<std::size_t>(end - begin));
    for (bool more = true; feed == content.npos && more;) {
      const std::size_t searched = content.size();
      more = in.append(content, position(), step);
      feed = content.find('\n', searched);
    }
    if (feed != content.npos) content.resize(feed + 1);
  }
  if (part > 0) {
    const std::size_t feed = content.find('\n');
    content.erase(0, feed == content.npos ? feed : feed + 1);
  }
  return content;
}

class InputFiles {
 public:
  std::set<FileId> ids;
};

InputRecord::InputRecord() : outermost_(!current) {
  if (outermost_) current = std::make_shared<InputFiles>();
}
InputRecord::~InputRecord() {
  if (outermost_) current.reset();
}

std::shared_ptr<const InputFiles> recordedInputs() {
  return current;
}

void recordInput(const fs::path& file) {
  if (!current) return;
  if (const auto id = idOf(file)) current->ids.insert(*id);
}

bool isInput(const fs::path& file, const std::shared_ptr<const InputFiles>& inputs) {
  if (!inputs) return false;
  const auto id = idOf(file);
  return id && inputs->ids.count(*id) > 0;
}

}  // namespace packmesh

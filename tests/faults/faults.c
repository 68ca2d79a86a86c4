/* SPDX-License-Identifier: AGPL-3.0-or-later
 * Loaded before the C library (LD_PRELOAD): lets calls for files below a folder fail, or sends a signal at them, so that
 * what a machine does rarely happens at every step.
 *   FAULT_FOLDER  folder, absolute
 *   FAULT         term-before:n, term-after:n: SIGTERM around the n-th call; eio:n: it and all later writes fail with EIO
 *   FAULT_RANK    the rank of Open MPI that it happens to (all, if not set)
 * "fault" is written to stderr when it happens. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static int calls = 0;

static int below_folder(const char* path) {
  const char* folder = getenv("FAULT_FOLDER");
  const char* rank = getenv("FAULT_RANK");
  const char* own = getenv("OMPI_COMM_WORLD_RANK");
  if (!folder || !path || (rank && own && strcmp(rank, own) != 0)) return 0;
  if (path[0] != '/') return 1; /* tests run in the folder */
  return strncmp(path, folder, strlen(folder)) == 0;
}

static int descriptor_below_folder(int descriptor) {
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length <= 0) return 0;
  path[length] = '\0';
  return path[0] == '/' && below_folder(path);
}

static int is_now(const char* what, int later) {
  const char* fault = getenv("FAULT");
  const size_t length = strlen(what);
  if (!fault || strncmp(fault, what, length) != 0 || fault[length] != ':') return 0;
  const int n = atoi(fault + length + 1);
  const int now = later ? calls >= n : calls == n;
  if (calls == n && write(STDERR_FILENO, "fault\n", 6) < 0) abort();
  return now;
}

static void before(int counts) {
  if (!counts) return;
  ++calls;
  if (is_now("term-before", 0)) kill(getpid(), SIGTERM);
}
static void after(int counts) {
  const int error = errno;
  if (counts && is_now("term-after", 0)) kill(getpid(), SIGTERM);
  errno = error;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define AROUND(counts, type, call)       \
  const int counted = (counts);          \
  before(counted);                       \
  const type result = (call);            \
  after(counted);                        \
  return result
#define FAILING(counts, type, call)            \
  const int counted = (counts);                \
  before(counted);                             \
  if (counted && is_now("eio", 1)) {           \
    errno = EIO;                               \
    return -1;                                 \
  }                                            \
  const type result = (call);                  \
  after(counted);                              \
  return result

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, int) : 0;
  va_end(more);
  AROUND(below_folder(path), int, REAL(open)(path, flags, mode));
}
int flock(int descriptor, int what) {
  AROUND(descriptor_below_folder(descriptor), int, REAL(flock)(descriptor, what));
}
int mkdir(const char* path, mode_t mode) {
  AROUND(below_folder(path), int, REAL(mkdir)(path, mode));
}
int rmdir(const char* path) {
  AROUND(below_folder(path), int, REAL(rmdir)(path));
}
int unlink(const char* path) {
  AROUND(below_folder(path), int, REAL(unlink)(path));
}
int link(const char* from, const char* to) {
  AROUND(below_folder(to), int, REAL(link)(from, to));
}
int rename(const char* from, const char* to) {
  FAILING(below_folder(to), int, REAL(rename)(from, to));
}
int close(int descriptor) {
  AROUND(descriptor_below_folder(descriptor), int, REAL(close)(descriptor));
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t position) {
  FAILING(descriptor_below_folder(descriptor), ssize_t, REAL(pwrite)(descriptor, data, size, position));
}
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t position) {
  FAILING(descriptor_below_folder(descriptor), ssize_t, REAL(pwrite64)(descriptor, data, size, position));
}
ssize_t write(int descriptor, const void* data, size_t size) {
  FAILING(descriptor_below_folder(descriptor), ssize_t, REAL(write)(descriptor, data, size));
}
int fsync(int descriptor) {
  FAILING(descriptor_below_folder(descriptor), int, REAL(fsync)(descriptor));
}

/* SPDX-License-Identifier: AGPL-3.0-or-later
 * Loaded before the C library (LD_PRELOAD): lets calls for files below a folder fail, or sends a signal at them, so that
 * what a machine does rarely happens at every step.
 *   FAULT_FOLDER  folder, absolute
 *   FAULT         term-before:n, term-after:n: SIGTERM around the n-th call; eio:n: it and all later writes fail with EIO;
 *                 full: a disk with little room; read-only: a disk that cannot be changed
 *   FAULT_DISK    for full: a file elsewhere with a struct disk
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
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
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

static int is_read_only(int counts) {
  const char* fault = getenv("FAULT");
  if (!counts || !fault || strcmp(fault, "read-only") != 0) return 0;
  errno = EROFS;
  return 1;
}

/* What all ranks share of a disk with little room. */
struct disk {
  long left; /* [bytes] */
  struct {
    long inode, bytes; /* 0: of no file */
  } files[100];
};
static struct disk* disk(void) {
  static struct disk* shared = NULL;
  const char* fault = getenv("FAULT");
  const char* file = getenv("FAULT_DISK");
  if (shared || !fault || !file || strcmp(fault, "full") != 0) return shared;
  const int descriptor = (int)syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC, 0);
  void* const memory = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (memory == MAP_FAILED) abort();
  return shared = memory;
}
/* The bytes of a file. */
static long* bytes_of(const struct stat* info) {
  for (int i = 0; i < 100; ++i) {
    long inode = 0;
    if (__atomic_compare_exchange_n(&disk()->files[i].inode, &inode, (long)info->st_ino, 0, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST) ||
        inode == (long)info->st_ino)
      return &disk()->files[i].bytes;
  }
  abort();
}
/* How much of a write there is room for. */
static size_t taken(int descriptor, size_t size) {
  struct stat info;
  if (!disk() || fstat(descriptor, &info) != 0) return size;
  long before = __atomic_load_n(&disk()->left, __ATOMIC_SEQ_CST), part;
  do
    part = before < (long)size ? before : (long)size;
  while (!__atomic_compare_exchange_n(&disk()->left, &before, before - part, 0, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST));
  __atomic_add_fetch(bytes_of(&info), part, __ATOMIC_SEQ_CST);
  return (size_t)part;
}
/* A file is emptied, or its last name goes away. */
static void empty(const struct stat* info) {
  if (disk() && info->st_ino) __atomic_add_fetch(&disk()->left, __atomic_exchange_n(bytes_of(info), 0, __ATOMIC_SEQ_CST), __ATOMIC_SEQ_CST);
}
/* What goes away with a name: no file, if it has others. */
static struct stat last_of(const char* path) {
  struct stat info;
  if (!disk() || lstat(path, &info) != 0 || !S_ISREG(info.st_mode) || info.st_nlink > 1) info.st_ino = 0;
  return info;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define AROUND(counts, type, call) \
  const int counted = (counts);    \
  before(counted);                 \
  const type result = (call);      \
  after(counted);                  \
  return result
#define FAILING(counts, type, call) \
  const int counted = (counts);     \
  before(counted);                  \
  if (counted && is_now("eio", 1)) { \
    errno = EIO;                    \
    return -1;                      \
  }                                 \
  const type result = (call);       \
  after(counted);                   \
  return result
#define CHANGING(path, call)            \
  const int below = below_folder(path); \
  if (is_read_only(below)) return -1;   \
  AROUND(below, int, call)
#define WRITING(call)                                              \
  const int below = descriptor_below_folder(descriptor);           \
  const size_t part = below ? taken(descriptor, size) : size;      \
  if (part == 0 && size > 0) {                                     \
    errno = ENOSPC;                                                \
    return -1;                                                     \
  }                                                                \
  FAILING(below, ssize_t, call)

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, int) : 0;
  va_end(more);
  const int below = below_folder(path);
  if (flags & (O_CREAT | O_WRONLY | O_RDWR) && is_read_only(below)) return -1;
  AROUND(below, int, REAL(open)(path, flags, mode));
}
int mkstemp(char* pattern) {
  return is_read_only(below_folder(pattern)) ? -1 : REAL(mkstemp)(pattern);
}
int flock(int descriptor, int what) {
  AROUND(descriptor_below_folder(descriptor), int, REAL(flock)(descriptor, what));
}
int mkdir(const char* path, mode_t mode) {
  CHANGING(path, REAL(mkdir)(path, mode));
}
int rmdir(const char* path) {
  CHANGING(path, REAL(rmdir)(path));
}
static int really_unlink(const char* path) {
  const struct stat last = last_of(path);
  const int result = REAL(unlink)(path);
  if (result == 0) empty(&last);
  return result;
}
int unlink(const char* path) {
  CHANGING(path, really_unlink(path));
}
int link(const char* from, const char* to) {
  CHANGING(to, REAL(link)(from, to));
}
static int really_rename(const char* from, const char* to) {
  const struct stat last = last_of(to);
  const int result = REAL(rename)(from, to);
  if (result == 0) empty(&last);
  return result;
}
int rename(const char* from, const char* to) {
  if (is_read_only(below_folder(to))) return -1;
  FAILING(below_folder(to), int, really_rename(from, to));
}
int close(int descriptor) {
  AROUND(descriptor_below_folder(descriptor), int, REAL(close)(descriptor));
}
int ftruncate(int descriptor, off_t length) {
  struct stat info;
  const int result = REAL(ftruncate)(descriptor, length);
  if (result == 0 && length == 0 && disk() && fstat(descriptor, &info) == 0) empty(&info);
  return result;
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t position) {
  WRITING(REAL(pwrite)(descriptor, data, part, position));
}
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t position) {
  WRITING(REAL(pwrite64)(descriptor, data, part, position));
}
ssize_t write(int descriptor, const void* data, size_t size) {
  WRITING(REAL(write)(descriptor, data, part));
}
int fsync(int descriptor) {
  FAILING(descriptor_below_folder(descriptor), int, REAL(fsync)(descriptor));
}

// SPDX-License-Identifier: BSD-3-Clause
// Preloaded into a program under test: the n-th call of one kind fails. $CAS_TEST_FAIL is
// KIND:N[+MORE][:PROGRAM[:THREAD]]. With MORE that many calls after the n-th fail, too; with
// PROGRAM calls fail only in the program of that name, with THREAD only on its threads of that
// name. With N 0 none fails. The file $CAS_TEST_FAILED is made when a call has failed;
// $CAS_TEST_FAILED.count gets the number of calls when the program ends.
//
//   read     read, readv, pread, fread, readdir
//   write    write, writev, pwrite, fwrite, fputs, fputc, fflush
//   open     open, openat, fopen, opendir
//   close    close and fclose of a regular file with bytes that no fsync has followed: half of the
//            file is gone
//   fsync    fsync, fdatasync
//   rename   rename, renameat, renameat2
//   accept   accept, accept4
//   receive  recv, recvfrom, recvmsg, recvmmsg
//   send     send, sendto, sendmsg, sendmmsg
//   malloc   malloc, calloc, realloc, posix_memalign, aligned_alloc
//
// std::fstream opens with fopen, reads with read, writes with write and writev and ends with
// fclose: libstdc++ calls them through its own table of symbols, which a preloaded library serves.
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <cstdarg>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
}

namespace {

enum class Call {
  kNone,
  kRead,
  kWrite,
  kOpen,
  kClose,
  kFsync,
  kRename,
  kAccept,
  kReceive,
  kSend,
  kMalloc
};

constexpr const char* kNames[] = {"",       "read",   "write",   "open", "close", "fsync",
                                  "rename", "accept", "receive", "send", "malloc"};

Call call = Call::kNone;
constexpr std::size_t kMaxName = 16;  // of the kernel
constexpr std::size_t kMaxPath = 4096;
constexpr std::size_t kDescriptors = 1024;

std::atomic<long> calls{0};
long first = 0;  // number of the first call that fails; 0: none
long last = 0;
char thread[kMaxName] = "";  // empty: all
std::array<std::atomic<bool>, kDescriptors> unsynced{};

void read_wish() {
  const char* const wish = std::getenv("CAS_TEST_FAIL");
  const char* const count = wish == nullptr ? nullptr : std::strchr(wish, ':');
  if (count == nullptr) return;
  const char* wanted = std::strchr(count + 1, ':');
  if (wanted != nullptr) {
    const std::size_t length = std::strcspn(++wanted, ":");
    const char* const name = program_invocation_short_name;
    if (std::strlen(name) != length || std::strncmp(wanted, name, length) != 0) return;
    if (wanted[length] == ':') std::strncpy(thread, wanted + length + 1, kMaxName - 1);
  }
  char* end = nullptr;
  first = std::strtol(count + 1, &end, 10);
  last = first + (*end == '+' ? std::strtol(end + 1, nullptr, 10) : 0);
  for (int i = 1; i <= static_cast<int>(Call::kMalloc); ++i) {
    if (std::strncmp(wish, kNames[i], static_cast<std::size_t>(count - wish)) == 0 &&
        kNames[i][count - wish] == '\0') {
      call = static_cast<Call>(i);
    }
  }
}

int (*program)(int, char**, char**) = nullptr;

/// Calls fail from main() on, not those of the loader and of static objects.
int start_program(int argc, char** argv, char** environment) {
  read_wish();
  return program(argc, argv, environment);
}

/// Writes the file $CAS_TEST_FAILED, by system calls alone: it may run inside malloc.
/// @param ending  end of the file's name
void leave_mark(const char* ending, const char* text) {
  const char* const mark = std::getenv("CAS_TEST_FAILED");
  std::array<char, kMaxPath> path{};
  if (mark == nullptr || std::strlen(mark) + std::strlen(ending) >= path.size()) return;
  std::strcpy(path.data(), mark);
  std::strcat(path.data(), ending);
  const long fd =
      ::syscall(SYS_openat, AT_FDCWD, path.data(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (fd < 0) return;
  ::syscall(SYS_write, fd, text, std::strlen(text));
  ::syscall(SYS_close, fd);
}

__attribute__((destructor)) void leave_count() {
  if (call == Call::kNone) return;
  std::array<char, 32> text{};
  std::to_chars(text.data(), text.data() + text.size() - 1, calls.load());
  leave_mark(".count", text.data());
}

bool is_wanted_thread() {
  if (thread[0] == 0) return true;
  char name[kMaxName] = "";
  ::prctl(PR_GET_NAME, name);
  return std::strcmp(name, thread) == 0;
}

bool fails(Call kind, int error) {
  if (kind != call || !is_wanted_thread()) return false;
  const long number = calls.fetch_add(1, std::memory_order_relaxed) + 1;
  if (number < first || number > last) return false;
  leave_mark("", "");
  errno = error;
  return true;
}

/// A call on a descriptor. An eventfd, a timer or a pipe does not fail: it has no disk, line or
/// network.
bool fails(Call kind, int error, int fd) {
  if (kind != call) return false;
  struct stat status {};
  const bool known = ::fstat(fd, &status) == 0;
  const bool in_memory = known && ((status.st_mode & S_IFMT) == 0 || S_ISFIFO(status.st_mode));
  return !in_memory && fails(kind, error);
}

/// A call of stdio: ferror() is set, as after a real failure.
bool fails(Call kind, int error, FILE* stream) {
  if (!fails(kind, error)) return false;
  constexpr int kErrorSeen = 0x20;  // _IO_ERR_SEEN
  stream->_flags |= kErrorSeen;
  return true;
}

void set_unsynced(int fd, bool to) {
  if (fd >= 0 && fd < static_cast<int>(kDescriptors)) {
    unsynced[static_cast<std::size_t>(fd)].store(to, std::memory_order_relaxed);
  }
}

bool take_unsynced(int fd) {
  return fd >= 0 && fd < static_cast<int>(kDescriptors) &&
         unsynced[static_cast<std::size_t>(fd)].exchange(false, std::memory_order_relaxed);
}

int synced(int fd) {
  take_unsynced(fd);
  return fd;
}

/// Whether closing this descriptor fails: bytes that were written since the last fsync are lost.
bool close_fails(int fd) {
  struct stat status {};
  if (!take_unsynced(fd) || ::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) return false;
  if (!fails(Call::kClose, EIO)) return false;
  if (::ftruncate(fd, status.st_size / 2) != 0) std::abort();
  return true;
}

mode_t mode_of(int flags, va_list more) {
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return makes ? static_cast<mode_t>(va_arg(more, int)) : 0;
}

}  // namespace

#define CAS_TEST_EXPORT extern "C" __attribute__((visibility("default")))
#define CAS_TEST_OPEN(name)                                             \
  CAS_TEST_EXPORT int name(const char* path, int flags, ...) {          \
    va_list more;                                                       \
    va_start(more, flags);                                              \
    const mode_t mode = mode_of(flags, more);                           \
    va_end(more);                                                       \
    if (fails(Call::kOpen, EMFILE)) return -1;                          \
    const long fd = ::syscall(SYS_openat, AT_FDCWD, path, flags, mode); \
    return static_cast<int>(fd);                                        \
  }
#define CAS_TEST_OPENAT(name)                                                  \
  CAS_TEST_EXPORT int name(int folder, const char* path, int flags, ...) {     \
    va_list more;                                                              \
    va_start(more, flags);                                                     \
    const mode_t mode = mode_of(flags, more);                                  \
    va_end(more);                                                              \
    if (fails(Call::kOpen, EMFILE)) return -1;                                 \
    return static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode)); \
  }
/// A call that returns `failed` in place of what the C library's returns, where `condition` holds.
#define CAS_TEST_CALL(condition, failed, result, name, parameters, arguments)                   \
  CAS_TEST_EXPORT result name parameters {                                                      \
    if (condition) return failed;                                                               \
    static const auto real = reinterpret_cast<result(*) parameters>(::dlsym(RTLD_NEXT, #name)); \
    return real arguments;                                                                      \
  }
/// The same for calls that write: the descriptor has bytes that may be lost at its close.
#define CAS_TEST_WRITE(fd, condition, failed, result, name, parameters, arguments)              \
  CAS_TEST_EXPORT result name parameters {                                                      \
    if (condition) return failed;                                                               \
    set_unsynced(fd, true);                                                                     \
    static const auto real = reinterpret_cast<result(*) parameters>(::dlsym(RTLD_NEXT, #name)); \
    return real arguments;                                                                      \
  }

using Main = int (*)(int, char**, char**);
CAS_TEST_EXPORT int __libc_start_main(Main main, int argc, char** argv, void (*begin)(),
                                      void (*finish)(), void (*unload)(), void* stack) {
  program = main;
  using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
  const auto real = reinterpret_cast<Start>(::dlsym(RTLD_NEXT, "__libc_start_main"));
  return real(start_program, argc, argv, begin, finish, unload, stack);
}

CAS_TEST_OPEN(open)
CAS_TEST_OPEN(open64)
CAS_TEST_OPENAT(openat)
CAS_TEST_OPENAT(openat64)
CAS_TEST_CALL(fails(Call::kOpen, EMFILE), nullptr, FILE*, fopen,
              (const char* path, const char* mode), (path, mode))
CAS_TEST_CALL(fails(Call::kOpen, EMFILE), nullptr, FILE*, fopen64,
              (const char* path, const char* mode), (path, mode))
CAS_TEST_CALL(fails(Call::kOpen, EMFILE), nullptr, DIR*, opendir, (const char* path), (path))

CAS_TEST_CALL(fails(Call::kRead, EIO, fd), -1, ssize_t, read,
              (int fd, void* into, std::size_t size), (fd, into, size))
CAS_TEST_CALL(fails(Call::kRead, EIO, fd), -1, ssize_t, readv,
              (int fd, const struct iovec* parts, int count), (fd, parts, count))
CAS_TEST_CALL(fails(Call::kRead, EIO, fd), -1, ssize_t, pread,
              (int fd, void* into, std::size_t size, off_t at), (fd, into, size, at))
CAS_TEST_CALL(fails(Call::kRead, EIO, fd), -1, ssize_t, pread64,
              (int fd, void* into, std::size_t size, off64_t at), (fd, into, size, at))
CAS_TEST_CALL(fails(Call::kRead, EIO, stream), 0, std::size_t, fread,
              (void* into, std::size_t size, std::size_t count, FILE* stream),
              (into, size, count, stream))
CAS_TEST_CALL(fails(Call::kRead, EIO), nullptr, dirent*, readdir, (DIR * folder), (folder))

CAS_TEST_WRITE(fd, fails(Call::kWrite, ENOSPC, fd), -1, ssize_t, write,
               (int fd, const void* from, std::size_t size), (fd, from, size))
CAS_TEST_WRITE(fd, fails(Call::kWrite, ENOSPC, fd), -1, ssize_t, writev,
               (int fd, const struct iovec* parts, int count), (fd, parts, count))
CAS_TEST_WRITE(fd, fails(Call::kWrite, ENOSPC, fd), -1, ssize_t, pwrite,
               (int fd, const void* from, std::size_t size, off_t at), (fd, from, size, at))
CAS_TEST_WRITE(fd, fails(Call::kWrite, ENOSPC, fd), -1, ssize_t, pwrite64,
               (int fd, const void* from, std::size_t size, off64_t at), (fd, from, size, at))
CAS_TEST_WRITE(::fileno(stream), fails(Call::kWrite, ENOSPC, stream), 0, std::size_t, fwrite,
               (const void* from, std::size_t size, std::size_t count, FILE* stream),
               (from, size, count, stream))
CAS_TEST_WRITE(::fileno(stream), fails(Call::kWrite, ENOSPC, stream), EOF, int, fputs,
               (const char* text, FILE* stream), (text, stream))
CAS_TEST_WRITE(::fileno(stream), fails(Call::kWrite, ENOSPC, stream), EOF, int, fputc,
               (int one, FILE* stream), (one, stream))
CAS_TEST_CALL(stream != nullptr && fails(Call::kWrite, ENOSPC, stream), EOF, int, fflush,
              (FILE * stream), (stream))

CAS_TEST_CALL(fails(Call::kFsync, EIO), -1, int, fsync, (int fd), (synced(fd)))
CAS_TEST_CALL(fails(Call::kFsync, EIO), -1, int, fdatasync, (int fd), (synced(fd)))
CAS_TEST_CALL(fails(Call::kRename, EIO), -1, int, rename, (const char* from, const char* to),
              (from, to))
CAS_TEST_CALL(fails(Call::kRename, EIO), -1, int, renameat,
              (int from_folder, const char* from, int to_folder, const char* to),
              (from_folder, from, to_folder, to))
CAS_TEST_CALL(fails(Call::kRename, EIO), -1, int, renameat2,
              (int from_folder, const char* from, int to_folder, const char* to,
               unsigned int flags),
              (from_folder, from, to_folder, to, flags))

CAS_TEST_CALL(fails(Call::kAccept, EMFILE), -1, int, accept,
              (int fd, sockaddr* from, socklen_t* size), (fd, from, size))
CAS_TEST_CALL(fails(Call::kAccept, EMFILE), -1, int, accept4,
              (int fd, sockaddr* from, socklen_t* size, int flags), (fd, from, size, flags))
CAS_TEST_CALL(fails(Call::kReceive, ENOMEM), -1, ssize_t, recv,
              (int fd, void* into, std::size_t size, int flags), (fd, into, size, flags))
CAS_TEST_CALL(fails(Call::kReceive, ENOMEM), -1, ssize_t, recvfrom,
              (int fd, void* into, std::size_t size, int flags, sockaddr* from, socklen_t* length),
              (fd, into, size, flags, from, length))
CAS_TEST_CALL(fails(Call::kReceive, ENOMEM), -1, ssize_t, recvmsg,
              (int fd, struct msghdr* message, int flags), (fd, message, flags))
CAS_TEST_CALL(fails(Call::kReceive, ENOMEM), -1, int, recvmmsg,
              (int fd, struct mmsghdr* messages, unsigned int count, int flags,
               struct timespec* timeout),
              (fd, messages, count, flags, timeout))
CAS_TEST_CALL(fails(Call::kSend, ENOBUFS), -1, ssize_t, send,
              (int fd, const void* from, std::size_t size, int flags), (fd, from, size, flags))
CAS_TEST_CALL(fails(Call::kSend, ENOBUFS), -1, ssize_t, sendto,
              (int fd, const void* from, std::size_t size, int flags, const sockaddr* to,
               socklen_t length),
              (fd, from, size, flags, to, length))
CAS_TEST_CALL(fails(Call::kSend, ENOBUFS), -1, ssize_t, sendmsg,
              (int fd, const struct msghdr* message, int flags), (fd, message, flags))
CAS_TEST_CALL(fails(Call::kSend, ENOBUFS), -1, int, sendmmsg,
              (int fd, struct mmsghdr* messages, unsigned int count, int flags),
              (fd, messages, count, flags))

/// The descriptor is closed in any case, as Linux does it.
CAS_TEST_EXPORT int close(int fd) {
  const bool failed = close_fails(fd);
  const auto closed = static_cast<int>(::syscall(SYS_close, fd));
  if (failed) errno = EIO;
  return failed ? -1 : closed;
}

CAS_TEST_EXPORT int fclose(FILE* stream) {
  static const auto flush = reinterpret_cast<int (*)(FILE*)>(::dlsym(RTLD_NEXT, "fflush"));
  static const auto real = reinterpret_cast<int (*)(FILE*)>(::dlsym(RTLD_NEXT, "fclose"));
  flush(stream);
  const bool failed = close_fails(::fileno(stream));
  const int closed = real(stream);
  if (failed) errno = EIO;
  return failed ? EOF : closed;
}

CAS_TEST_EXPORT void* malloc(std::size_t size) {
  return fails(Call::kMalloc, ENOMEM) ? nullptr : __libc_malloc(size);
}
CAS_TEST_EXPORT void* calloc(std::size_t count, std::size_t size) {
  return fails(Call::kMalloc, ENOMEM) ? nullptr : __libc_calloc(count, size);
}
CAS_TEST_EXPORT void* realloc(void* block, std::size_t size) {
  return fails(Call::kMalloc, ENOMEM) ? nullptr : __libc_realloc(block, size);
}
CAS_TEST_EXPORT void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return fails(Call::kMalloc, ENOMEM) ? nullptr : __libc_memalign(alignment, size);
}
CAS_TEST_EXPORT int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  if (fails(Call::kMalloc, ENOMEM)) return ENOMEM;
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}

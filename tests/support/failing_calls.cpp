// SPDX-License-Identifier: BSD-3-Clause
// Preloaded into a program under test: the n-th call of one kind fails. $CAS_TEST_FAIL is
// CALL:N[+MORE][:PROGRAM[:THREAD]], with CALL one of read, write, open, accept, fsync and malloc;
// with MORE so many after it fail, too; with PROGRAM only in the program of that name, with THREAD
// only on its threads of that name. The file $CAS_TEST_FAILED is made when a call has failed.
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdarg>
#include <cstdlib>
#include <cstring>

extern "C" void* __libc_malloc(std::size_t size);

namespace {

enum class Call { kNone, kRead, kWrite, kOpen, kAccept, kFsync, kMalloc };

constexpr const char* kNames[] = {"", "read", "write", "open", "accept", "fsync", "malloc"};

Call call = Call::kNone;
constexpr std::size_t kMaxName = 16;  // of the kernel

std::atomic<long> left{0};
long more = 0;
char thread[kMaxName] = "";  // empty: all

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
  left = std::strtol(count + 1, &end, 10);
  if (*end == '+') more = std::strtol(end + 1, nullptr, 10);
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

/// By system calls alone: it may run inside malloc.
void leave_mark() {
  const char* const mark = std::getenv("CAS_TEST_FAILED");
  if (mark == nullptr) return;
  const long fd = ::syscall(SYS_openat, AT_FDCWD, mark, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (fd >= 0) ::syscall(SYS_close, fd);
}

bool is_wanted_thread() {
  if (thread[0] == 0) return true;
  char name[kMaxName] = "";
  ::prctl(PR_GET_NAME, name);
  return std::strcmp(name, thread) == 0;
}

bool fails(Call kind, int error) {
  if (kind != call || !is_wanted_thread()) return false;
  const long at = left.fetch_sub(1, std::memory_order_relaxed);
  if (at > 1 || at < 1 - more) return false;
  leave_mark();
  errno = error;
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
/// Calls that take what they take; the real one is the C library's.
#define CAS_TEST_CALL(kind, error, result, name, parameters, arguments)                         \
  CAS_TEST_EXPORT result name parameters {                                                      \
    if (fails(kind, error)) return -1;                                                          \
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
CAS_TEST_CALL(Call::kRead, EIO, ssize_t, read, (int fd, void* into, std::size_t size),
              (fd, into, size))
CAS_TEST_CALL(Call::kWrite, ENOSPC, ssize_t, write, (int fd, const void* from, std::size_t size),
              (fd, from, size))
CAS_TEST_CALL(Call::kWrite, ENOSPC, ssize_t, writev, (int fd, const struct iovec* parts, int count),
              (fd, parts, count))
CAS_TEST_CALL(Call::kAccept, EMFILE, int, accept, (int fd, sockaddr* from, socklen_t* size),
              (fd, from, size))
CAS_TEST_CALL(Call::kAccept, EMFILE, int, accept4,
              (int fd, sockaddr* from, socklen_t* size, int flags), (fd, from, size, flags))
CAS_TEST_CALL(Call::kFsync, EIO, int, fsync, (int fd), (fd))
CAS_TEST_CALL(Call::kFsync, EIO, int, fdatasync, (int fd), (fd))

CAS_TEST_EXPORT void* malloc(std::size_t size) {
  return fails(Call::kMalloc, ENOMEM) ? nullptr : __libc_malloc(size);
}

// SPDX-License-Identifier: BSD-3-Clause
// Preloaded into a program under test: a disk that hangs. While the file $CAS_TEST_HANG exists,
// opening a path that ends in $CAS_TEST_HANG_AT waits; $CAS_TEST_HANG.reached shows that a caller
// waits.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

void hang_at(const char* path) {
  const char* const hang = std::getenv("CAS_TEST_HANG");
  const char* const end = std::getenv("CAS_TEST_HANG_AT");
  if (hang == nullptr || end == nullptr || !std::string_view(path).ends_with(end)) return;
  if (::access(hang, F_OK) != 0) return;
  const std::string reached = std::string(hang) + ".reached";
  ::close(::creat(reached.c_str(), 0600));
  while (::access(hang, F_OK) == 0) ::usleep(10'000);
}

mode_t mode_of(int flags, va_list more) {
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return makes ? static_cast<mode_t>(va_arg(more, int)) : 0;
}

}  // namespace

#define CAS_TEST_OPEN(name)                                                                      \
  extern "C" __attribute__((visibility("default"))) int name(const char* path, int flags, ...) { \
    va_list more;                                                                                \
    va_start(more, flags);                                                                       \
    const mode_t mode = mode_of(flags, more);                                                    \
    va_end(more);                                                                                \
    hang_at(path);                                                                               \
    return reinterpret_cast<int (*)(const char*, int, mode_t)>(::dlsym(RTLD_NEXT, #name))(       \
        path, flags, mode);                                                                      \
  }
#define CAS_TEST_OPENAT(name)                                                                   \
  extern "C" __attribute__((visibility("default"))) int name(int folder, const char* path,      \
                                                             int flags, ...) {                  \
    va_list more;                                                                               \
    va_start(more, flags);                                                                      \
    const mode_t mode = mode_of(flags, more);                                                   \
    va_end(more);                                                                               \
    hang_at(path);                                                                              \
    return reinterpret_cast<int (*)(int, const char*, int, mode_t)>(::dlsym(RTLD_NEXT, #name))( \
        folder, path, flags, mode);                                                             \
  }

CAS_TEST_OPEN(open)
CAS_TEST_OPEN(open64)
CAS_TEST_OPENAT(openat)
CAS_TEST_OPENAT(openat64)

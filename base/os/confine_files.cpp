// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/confine_files.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/os/descriptor.hpp"

namespace cas::base {

namespace {

// Rights that came after the headers of Debian 12, by the version of Landlock that brought them.
constexpr std::uint64_t kRefer = 1ULL << 13;     // 2: moves between folders
constexpr std::uint64_t kTruncate = 1ULL << 14;  // 3

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;

/// Rights to write that this version of Landlock knows.
std::uint64_t write_rights(long version) {
  std::uint64_t rights = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                         LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                         LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                         LANDLOCK_ACCESS_FS_MAKE_SOCK | LANDLOCK_ACCESS_FS_MAKE_FIFO |
                         LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SYM;
  if (version >= 2) rights |= kRefer;
  if (version >= 3) rights |= kTruncate;
  return rights;
}

void allow(const Descriptor& rules, const std::filesystem::path& place, std::uint64_t rights) {
  const Descriptor opened(::open(place.c_str(), O_PATH | O_CLOEXEC));
  struct stat kind {};
  if (!opened || ::fstat(opened.get(), &kind) != 0) return;
  constexpr std::uint64_t kOfAFile =
      LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
  landlock_path_beneath_attr rule{};
  rule.allowed_access = S_ISDIR(kind.st_mode) ? rights : rights & kOfAFile;
  rule.parent_fd = opened.get();
  ::syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0U);
}

}  // namespace

bool confine_files(FileUse use, const std::vector<std::filesystem::path>& places) {
  const long version =
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return false;
  const std::uint64_t rights = use == FileUse::kRead ? kRead : write_rights(version);
  landlock_ruleset_attr confined{};
  confined.handled_access_fs = rights;
  const Descriptor rules(
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &confined, sizeof confined, 0U)));
  if (!rules) return false;
  for (const std::filesystem::path& place : places) allow(rules, place, rights);
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1UL, 0UL, 0UL, 0UL) == 0 &&
         ::syscall(SYS_landlock_restrict_self, rules.get(), 0U) == 0;
}

}  // namespace cas::base

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

namespace cas::test {

/// While it lives, no file of a process grows beyond a size: simulates a full disk without
/// privileges. The hard limit stays.
class FileSizeLimit {
 public:
  /// @param process  0: this one, whose SIGXFSZ is ignored from now on
  explicit FileSizeLimit(rlim_t bytes, pid_t process = 0) : process_(process) {
    if (process == 0) std::signal(SIGXFSZ, SIG_IGN);
    rlimit now{};
    ::prlimit(process_, RLIMIT_FSIZE, nullptr, &before_);
    now = before_;
    now.rlim_cur = bytes;
    ::prlimit(process_, RLIMIT_FSIZE, &now, nullptr);
  }
  ~FileSizeLimit() { ::prlimit(process_, RLIMIT_FSIZE, &before_, nullptr); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  pid_t process_;
  rlimit before_{};
};

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

/// How a program ended, and what it printed.
struct Ended {
  int code = -1;       ///< exit code, or 128 + signal; -1: it has not ended
  std::string output;  ///< standard output and error

  friend void PrintTo(const Ended& program, std::ostream* out) {
    *out << "exit code " << program.code << ":\n" << program.output;
  }
};

/// A program under test, with a notify socket of its own and its output in a file. It ends with the
/// object.
class ChildProcess {
 public:
  /// @param command  program and arguments
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits for READY=1. @return its STATUS; nullopt at the deadline or when the program has ended
  std::optional<std::string> wait_ready(base::Duration patience = kPatience);
  void signal(int number);
  /// Waits for the end. @return the exit code, 128 + signal, or nothing at the deadline
  std::optional<int> wait_exit(base::Duration patience = kPatience);
  /// Waits for the end. @return how it ended; code -1 at the deadline
  Ended end(base::Duration patience = kPatience);
  /// Standard output and error so far.
  std::string output() const;
  /// Waits until these words are in its output.
  bool prints(const std::string& words) const {
    return wait_until([&] { return output().find(words) != std::string::npos; });
  }
  pid_t pid() const { return pid_; }

 private:
  bool ended();

  TemporaryFolder folder_;
  int notify_fd_ = -1;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

/// The word after `name` in a status line of READY: "127.0.0.1:14561" after "sim".
/// @throws std::runtime_error when it is not there: a link that has no port yet
std::string word_after(const std::string& status, const std::string& name);

}  // namespace cas::test

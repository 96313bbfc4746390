// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"

namespace cas::hils {

/// How a process ended, and what it used.
struct ProcessEnd {
  int code = 0;         ///< exit code; 128 + signal when a signal ended it
  std::string words{};  ///< "was ended by signal 11 (Segmentation fault)"
  double cpu_s = 0;
  double max_rss_mib = 0;
};

/// A program in a process group of its own, its output in a file. It dies with the thread that
/// started it, and with the object.
class RowProcess {
 public:
  /// Starts it. @throws base::ConfigError
  RowProcess(std::vector<std::string> arguments, const std::filesystem::path& log_file);
  ~RowProcess();
  RowProcess(RowProcess&& other) noexcept;
  RowProcess& operator=(RowProcess&& other) = delete;

  /// Readable when the process has ended.
  int pidfd() const { return pidfd_.get(); }
  base::RunTime begin() const { return begin_; }
  /// Collects its end if it has ended.
  std::optional<ProcessEnd> poll_end();
  /// Ends the group at once.
  void kill();

 private:
  pid_t pid_ = -1;
  base::Descriptor pidfd_;
  base::RunTime begin_{};
};

/// Path that starts the running program again, also after its file was replaced.
inline constexpr const char* kSameProgram = "/proc/self/exe";
/// Where the running program lies, for commands that are printed or written.
std::filesystem::path own_program();

}  // namespace cas::hils

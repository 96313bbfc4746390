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

/// How a process ended.
struct ExitStatus {
  int code = 0;            ///< exit code; 128 + signal when a signal ended it
  double cpu_s = 0;        ///< user and system time
  double max_rss_mib = 0;  ///< most memory that it had at once
  std::string words;  ///< "ended with exit code 78", "was ended by signal 11 (Segmentation fault)"
};

/// A program started by hils, in its own process group, which dies with its parent.
///
/// The child's output goes to a file; a child with a NOTIFY_SOCKET says there that it is ready.
/// Waiting is by pidfd. The thread that constructs it must live as long as the child shall
/// (PDEATHSIG follows the thread).
class ChildProcess {
 public:
  struct Options {
    std::string name;                        ///< for messages: "casd"
    std::vector<std::string> arguments;      ///< argv, the program's path first
    std::filesystem::path log_file;          ///< standard output and error
    bool appends = false;                    ///< to the log file, else truncates it
    std::filesystem::path notify_socket{};   ///< empty: it has none, and is ready at once
    bool says_ready = true;                  ///< else it is taken to be ready at once
    std::filesystem::path cwd{};             ///< empty: this process's
    std::vector<std::string> environment{};  ///< "NAME=VALUE", over this process's
    bool ends_run = true;  ///< the supervisor stops the run where it ends by itself
  };

  /// Starts the program. @throws base::ConfigError when it cannot be started
  explicit ChildProcess(Options options);
  /// Kills the process group if it is still there.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  const std::string& name() const { return options_.name; }
  bool ends_run() const { return options_.ends_run; }
  int pidfd() const { return pidfd_.get(); }
  int notify_fd() const { return notify_.get(); }
  base::RunTime begin() const { return begin_; }

  /// Reads the messages on the notify socket. @return true once READY=1 has come
  bool take_notifications();
  bool ready() const { return ready_; }

  /// Collects the end of the process if it has ended.
  const std::optional<ExitStatus>& poll_exit();
  /// Waits for its end until `patience` after its begin. @return nullopt when it still runs then
  const std::optional<ExitStatus>& wait_exit(base::Duration patience);
  void terminate();  ///< SIGTERM to the group
  void kill();       ///< SIGKILL to the group
  /// The last lines of its output.
  std::string log_tail(std::size_t lines = 5) const;

 private:
  Options options_;
  base::Descriptor notify_;
  base::Descriptor pidfd_;
  base::RunTime begin_ = base::steady_now();
  pid_t pid_ = -1;
  bool ready_ = false;
  std::optional<ExitStatus> exit_;
};

/// The words of a command or an environment as exec() takes them, nullptr behind the last. They
/// point into `words`.
std::vector<char*> exec_words(std::vector<std::string>& words);

/// Path that starts the running program again, also after its file was replaced.
inline constexpr const char* kSameProgram = "/proc/self/exe";
/// Where the running program lies, for commands that are printed or written.
std::filesystem::path own_program();
/// Path of another program of CAS, which lies beside the running one.
std::filesystem::path sibling_program(const std::string& name);

}  // namespace cas::hils

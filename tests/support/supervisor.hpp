// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/unit_file.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

/// Keeps one program running as systemd does with a unit of Type=notify: it waits for READY=1,
/// starts the program again after a failure, RestartSec later, ends it when its watchdog is not
/// fed, and gives up at the start limit. Its times are those of the unit file. It lacks sandbox,
/// user and dependencies.
class Supervisor {
 public:
  enum class State { kStarting, kRunning, kWaiting, kStopped, kFailed };

  /// @param words  substitutes for words of the unit's commands, because the program is not
  ///               installed: {"/usr/bin/casd", the program built here}
  Supervisor(const UnitFile& unit, std::map<std::string, std::string> words);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Waits for READY=1 of the present process. @return its STATUS; nullopt at the deadline
  std::optional<std::string> wait_ready(base::Duration patience = kPatience);
  /// `systemctl restart`: SIGTERM, and once it has ended a new one at once.
  void restart();
  /// `systemctl reload`, as ExecReload says: SIGHUP.
  void reload();
  /// Sends a signal to the program. @return when
  base::RunTime signal(int number);

  State state() const;
  /// How often its watchdog was fed.
  int feeds() const;
  /// How often the program was started.
  int starts() const;
  pid_t pid() const;
  /// Standard output and error of all starts so far.
  std::string output() const;
  /// Waits until these words are in its output.
  bool prints(const std::string& words) const {
    return wait_until([&] { return output().find(words) != std::string::npos; });
  }

 private:
  void supervise();
  void start();
  bool may_start(base::RunTime now);
  void listen();
  void bury();
  void watch_over();
  bool restarts_after(int status) const;
  std::vector<std::string> command(const std::string& line) const;
  pid_t spawn(const std::vector<std::string>& command) const;

  UnitFile unit_;
  std::map<std::string, std::string> words_;
  base::Duration restart_after_;
  base::Duration watchdog_;
  base::Duration abort_patience_;  ///< from SIGABRT to SIGKILL
  TemporaryFolder folder_;
  base::Descriptor notify_;
  base::Descriptor wake_;
  base::Descriptor process_;  ///< pidfd
  base::RunTime next_start_{};
  base::RunTime fed_{};
  bool aborted_ = false;
  std::deque<base::RunTime> recent_starts_;
  std::atomic<bool> ending_{false};

  mutable std::mutex mutex_;  ///< guards the members below
  State state_ = State::kStopped;
  bool restart_wanted_ = false;
  pid_t pid_ = -1;
  int starts_ = 0;
  int feeds_ = 0;
  std::string status_;

  std::thread thread_;
};

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "hils/programs/child_process.hpp"

namespace cas::hils {

/// Thrown when a run cannot go on: a program died or did not get ready, or the user pressed Ctrl-C,
/// which interrupted() tells.
class RunStopped : public std::runtime_error {
 public:
  RunStopped(const std::string& sentence, bool interrupted)
      : std::runtime_error(sentence), interrupted_(interrupted) {}
  bool interrupted() const { return interrupted_; }

 private:
  bool interrupted_;
};

/// Starts the programs of a run and watches over them.
///
/// A thread waits on the pidfds and on SIGINT and SIGTERM (blocked in every thread, read from a
/// signalfd). When one of them comes, it ends all programs: their connections close, and
/// `check()` says why.
class Supervisor {
 public:
  /// How long a program may take until it is ready.
  static constexpr base::Duration kReadyTimeout = std::chrono::seconds(20);

  /// Blocks SIGINT, SIGTERM and SIGHUP for the process: construct before other threads start.
  Supervisor();
  /// Ends whatever still runs.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Starts a program and waits until it is ready. @throws RunStopped, base::ConfigError
  ChildProcess& start(ChildProcess::Options options, base::Duration timeout);
  /// Starts a program; several get ready at the same time. @throws RunStopped, base::ConfigError
  ChildProcess& launch(ChildProcess::Options options);
  /// Waits until a launched program is ready. @throws RunStopped
  void wait_ready(const ChildProcess& child, base::Duration timeout);

  /// Throws RunStopped when the run has been stopped.
  void check() const;
  /// Waits for `time` or until the run is stopped, whichever comes first. @throws RunStopped
  void wait(base::Duration time);

  /// From now on the remaining programs outlive the stop of the run by at most `patience`, so that
  /// they still take last calls; a second signal ends them at once. Zero: they end with it.
  void linger(base::Duration patience);
  /// Ends the programs of a stopped run.
  void end_lingering();

  /// Ends one program in good order: SIGTERM, then SIGKILL after `patience`. Its end is expected
  /// from now on. @return false when it had to be killed or ended with an error
  bool stop(ChildProcess& child, base::Duration patience);
  /// The same for several at once. @return one that did not end in good order, or null
  ChildProcess* stop(const std::vector<ChildProcess*>& children, base::Duration patience);

  /// How a program ended by itself that does not end the run; nullopt: it runs, or was ended.
  std::optional<std::string> own_end(ChildProcess& child);

  /// Ends one program at once, as a crash would. Its end is expected.
  void kill(ChildProcess& child);

  /// Processor time by program, for those that have ended.
  std::vector<std::pair<std::string, double>> cpu_s() const;

 private:
  void watch(const std::stop_token& stop);
  void wake();
  void on_signal();
  void on_exit(ChildProcess& child) CAS_REQUIRES(mutex_);
  void stop_run(const std::string& sentence, bool interrupted) CAS_REQUIRES(mutex_);
  void end_programs() CAS_REQUIRES(mutex_);
  int patience_ms() const;

  mutable base::Mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::unique_ptr<ChildProcess>> children_ CAS_GUARDED_BY(mutex_);
  std::set<const ChildProcess*> expected_to_end_ CAS_GUARDED_BY(mutex_);
  std::set<const ChildProcess*> ended_ CAS_GUARDED_BY(mutex_);  ///< whose end the watcher has seen
  std::string stopped_ CAS_GUARDED_BY(mutex_);                  ///< why; empty while all is well
  bool interrupted_ CAS_GUARDED_BY(mutex_) = false;
  base::Duration linger_ CAS_GUARDED_BY(mutex_){};
  std::optional<base::RunTime> end_at_ CAS_GUARDED_BY(mutex_);  ///< of a run that has been stopped
  base::Descriptor signals_;
  base::Descriptor wake_;
  std::jthread watcher_;
};

}  // namespace cas::hils

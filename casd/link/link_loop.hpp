// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/os/thread.hpp"
#include "casd/link/link.hpp"
#include "casd/link/look_pace.hpp"
#include "casd/link/wake_signal.hpp"

namespace cas::casd {

/// A thread with the links that it serves: one (threads: per_link) or all of them (single,
/// blocking).
///
///   watch: what does each link wait for? --> (LookPace) --> ppoll --> serve each link --+
///     ^---------------------------------------------------------------------------------+
///
/// LookPace: a moment's rest in a flood; it ends when something is due or the signal is raised.
class LinkLoop {
 public:
  LinkLoop(std::string name, base::ThreadOptions scheduling);
  ~LinkLoop();
  LinkLoop(const LinkLoop&) = delete;
  LinkLoop& operator=(const LinkLoop&) = delete;

  /// Starts the thread. @throws base::ConfigError when there is none to be had
  void start();
  /// Ends the thread and closes its links.
  void stop();

  /// From any thread; takes effect at the loop's next turn.
  void add(std::unique_ptr<Link> link);
  /// Closes the link; returns when it is closed.
  void remove(const Link* link);
  /// Runs `task` on the loop's thread; returns when it has run.
  void run_on_loop(const std::function<void()>& task);
  /// Makes the loop look again at what its links wait for. Does nothing on the loop's own thread.
  void wake();
  /// Whether the thread has turned within `patience`, and a nudge so that it can: ask regularly.
  bool answers(base::RunTime now, base::Duration patience);

 private:
  void run();
  void wait(base::RunTime now);
  void rest_until(base::RunTime end, base::RunTime now);
  std::uint64_t received() const;
  void wait_in_trouble(int error);
  void run_tasks();

  const std::string name_;
  const base::ThreadOptions scheduling_;
  WakeSignal signal_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::thread::id> thread_id_{};
  std::atomic<std::int64_t> last_turn_ns_{0};  ///< RunTime; 0 before the first
  std::mutex tasks_mutex_;
  std::vector<std::function<void()>> tasks_;
  std::vector<std::unique_ptr<Link>> links_;
  PollSet poll_set_;
  LookPace pace_;
  bool in_trouble_ = false;  ///< waiting failed, and that was said
  std::thread thread_;
};

}  // namespace cas::casd

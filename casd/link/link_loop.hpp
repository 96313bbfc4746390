// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "base/os/thread.hpp"
#include "base/time/clock.hpp"
#include "casd/link/link.hpp"
#include "casd/link/look_pace.hpp"
#include "casd/link/turn_meter.hpp"

namespace cas::casd {

/// Wakes a thread that waits in poll. Many calls before it looks cost one system call.
class WakeSignal {
 public:
  WakeSignal();
  /// From any thread.
  void raise();
  /// By the thread that was woken, before it looks at what there is to do.
  void lower();
  const OpenDescriptor& descriptor() const { return opened_; }

 private:
  base::Descriptor event_;
  OpenDescriptor opened_;  ///< `event_` for a PollSet
  std::atomic<bool> raised_{false};
};

/// Wakes a poll at a moment that is not near, and stays armed over many turns.
///
/// A time limit of poll itself is armed and taken back with each packet, and in a virtual machine
/// that costs more than a read. So a thread has this instead for what comes once in a while; it may
/// ring too early, when what was due has moved on.
class DistantAlarm {
 public:
  /// What is due sooner is left to the limit of poll itself, which needs no call to arm it.
  static constexpr base::Duration kNear = std::chrono::milliseconds(20);

  DistantAlarm();
  /// @return whether it will ring by then; false: it is too near, poll has to watch the time
  bool covers(base::RunTime due, base::RunTime now);
  /// Clears the alarm once it has rung.
  void stop();
  const OpenDescriptor& descriptor() const { return opened_; }

 private:
  base::Descriptor timer_;
  OpenDescriptor opened_;  ///< `timer_` for a PollSet
  base::RunTime rings_at_ = PollSet::kNever;
};

class LinkHome;

/// A thread with the links that it serves: all of them (threads: single, blocking), one
/// (per_link), or with `auto` those that do not flood.
///
///   watch: what does each link wait for? --> (LookPace) --> PollSet::wait --> serve each link --+
///     ^-----------------------------------------------------------------------------------------+
///
/// LookPace: a moment's rest in a flood; it ends when something is due or the signal is raised.
class LinkLoop {
 public:
  /// @param seek_core  the thread may choose its processor core, see CoreSeeker
  LinkLoop(std::string name, base::ThreadOptions scheduling, bool seek_core = false);
  ~LinkLoop();
  LinkLoop(const LinkLoop&) = delete;
  LinkLoop& operator=(const LinkLoop&) = delete;

  const std::string& name() const { return name_; }
  /// Measures each turn, all work between two rests, and aborts after one that exceeds a bound of
  /// excess(). To be called before start(). Builds with sanitizers or CAS_METER_TURNS always
  /// measure.
  void meter_turns() { metered_ = true; }
  /// Starts the thread. @throws base::ConfigError when there is none to be had
  void start();
  /// Ends the thread and closes its links.
  void stop();

  /// From any thread; takes effect at the loop's next turn. With an exception `link` stays with the
  /// caller.
  /// @param home    may take the link away; nullptr: it stays
  /// @param visits  the link is here only while it floods; its home takes it back
  void add(std::unique_ptr<Link>&& link, LinkHome* home = nullptr, bool visits = false);
  /// Closes the link; returns when it is closed. @return whether it was here
  bool remove(const Link* link);
  /// Runs `task` on the loop's thread; returns when it has run.
  void run_on_loop(const std::function<void()>& task);
  /// Makes the loop look again at what its links wait for. Does nothing on the loop's own thread.
  void wake();
  /// Whether the thread has turned within `patience`, and a nudge so that it can: ask regularly.
  bool answers(base::RunTime now, base::Duration patience);

 private:
  struct Resident {
    std::unique_ptr<Link> link;
    LinkHome* home = nullptr;
    bool visits = false;
    std::uint64_t received = 0;  ///< before this while of the pace
  };

  void run(const std::stop_token& stop);
  bool serve(base::RunTime now);
  base::RunTime wait(base::RunTime now);
  void begin_turn();
  void end_turn() const;
  void poll_until(base::RunTime due, base::RunTime now, base::RunTime began);
  void rest_until(base::RunTime end, base::RunTime now);
  void move_links(base::RunTime now);
  void note_received();
  std::vector<Resident>::iterator busiest();
  std::uint64_t received() const;
  Arrivals arrivals() const;
  void wait_in_trouble(int error);
  void run_tasks();

  const std::string name_;
  const base::ThreadOptions scheduling_;
  const bool seek_core_;
  bool metered_;
  WakeSignal signal_;
  std::atomic<std::thread::id> thread_id_{};
  std::atomic<std::int64_t> last_turn_ns_{0};  ///< RunTime; 0 before the first
  base::Mutex tasks_mutex_;
  std::vector<std::function<void()>> tasks_ CAS_GUARDED_BY(tasks_mutex_);
  std::vector<std::function<void()>> taken_;  ///< those under way; what lacks memory is tried again
  bool has_tasks_ = true;                     ///< perhaps
  std::vector<Resident> links_;
  static constexpr std::size_t kSignalEntry = 0;  ///< of the poll set
  static constexpr std::size_t kAlarmEntry = 1;
  PollSet poll_set_;
  DistantAlarm alarm_;
  LookPace pace_;
  std::optional<TurnMeter> meter_;
  base::Duration idle_{};    ///< in poll, so far
  bool in_trouble_ = false;  ///< waiting failed, and that was said
  std::jthread thread_;
};

}  // namespace cas::casd

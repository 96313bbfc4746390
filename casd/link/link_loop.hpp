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

namespace cas::casd {

/// How often a thread looks at its links while they are flooded.
///
/// Up to 50 packets a millisecond each packet is forwarded the moment it comes. What brings more
/// is looked at once in kPause: then several packets are read, routed and written with a system
/// call each time instead of one each, and who sends does not pay for waking this thread with every
/// packet. Network cards moderate their interrupts in the same way. A HIL link of 500 Hz, and a
/// lockstep run that waits for each answer, stay far below. kPause was chosen with the closed loop
/// of scripts/bench_router: with half of it a PTY still brings few packets at a look, a longer one
/// delays more and gains little.
class LookPace {
 public:
  static constexpr base::Duration kPause = std::chrono::microseconds(150);

  /// Without a flood for so long: it is over.
  static constexpr base::Duration kCalm = std::chrono::seconds(5);

  /// @param received  packets that have come so far, all links of the thread together
  /// @param idle      how long the thread has waited in poll so far; pauses do not count
  /// @return whether a span of 50 ms has ended, for which flood_lasts() answers anew
  bool looked(base::RunTime now, std::uint64_t received, base::Duration idle) {
    if (last_look_ == base::RunTime{}) last_flood_ = now;
    last_look_ = now;
    if (const auto moment = moment_.looked(now, received, idle)) {
      busy_ = moment->packets_ms > kBusyPackets;
    }
    const auto a_while = while_.looked(now, received, idle);
    if (!a_while) return false;
    flood_lasts_ = a_while->packets_ms > kBusyPackets ||
                   (a_while->packets_ms > kManyPackets && a_while->idle_share < kNoRest);
    // A thread of its own may bring rest to what goes on: the link stays there meanwhile.
    if (flood_lasts_ || a_while->packets_ms > kManyPackets) last_flood_ = now;
    return true;
  }

  /// Not before this: in the past, or not long ago, unless there is a flood.
  base::RunTime next_look() const { return busy_ ? last_look_ + kPause : last_look_; }
  bool busy() const { return busy_; }
  /// Judged by 50 ms: a burst is shorter, and a flood on a busy machine has gaps. A thread that is
  /// hardly idle is flooded by fewer packets.
  bool flood_lasts() const { return flood_lasts_; }
  bool flood_is_over(base::RunTime now) const { return now - last_flood_ >= kCalm; }
  /// A link has joined; its earlier packets do not count.
  void add_link(std::uint64_t received) {
    moment_.add_link(received);
    while_.add_link(received);
  }

 private:
  static constexpr double kBusyPackets = 50;  ///< a millisecond
  static constexpr double kManyPackets = 10;  ///< a millisecond, where the thread is hardly idle
  static constexpr double kNoRest = 0.1;      ///< share of idle time that is hardly any

  /// What came in spans of a given length.
  class Span {
   public:
    struct Figures {
      double packets_ms;  ///< packets a millisecond
      double idle_share;  ///< 0 to 1
    };
    explicit Span(base::Duration length) : length_(length) {}

    /// @return figures of the span that has ended
    std::optional<Figures> looked(base::RunTime now, std::uint64_t received, base::Duration idle) {
      const base::Duration elapsed = now - begin_;
      if (elapsed < length_) return std::nullopt;
      // A link that was taken away takes its packets along.
      const std::uint64_t came = received > received_before_ ? received - received_before_ : 0;
      const Figures figures{static_cast<double>(came) / (base::to_seconds(elapsed) * 1e3),
                            base::to_seconds(idle - idle_before_) / base::to_seconds(elapsed)};
      begin_ = now;
      received_before_ = received;
      idle_before_ = idle;
      return figures;
    }
    void add_link(std::uint64_t received) { received_before_ += received; }

   private:
    base::Duration length_;
    base::RunTime begin_{};
    std::uint64_t received_before_ = 0;
    base::Duration idle_before_{};
  };

  Span moment_{std::chrono::milliseconds(1)};
  Span while_{std::chrono::milliseconds(50)};
  base::RunTime last_look_{};
  base::RunTime last_flood_{};  ///< of the last span with many packets; before: the first look
  bool busy_ = false;
  bool flood_lasts_ = false;
};

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
  /// It has rung.
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
  base::Duration idle_{};    ///< in poll, so far
  bool in_trouble_ = false;  ///< waiting failed, and that was said
  std::jthread thread_;
};

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::casd {

/// What a thread did between two looks at its figures.
struct CoreSample {
  std::uint64_t turns = 0;    ///< how often it began to run
  base::Duration elapsed{};   ///< real time
  base::Duration ran{};       ///< its processor time
  base::Duration queued{};    ///< ready to run, but others ran
  std::uint64_t stamped = 0;  ///< packets whose arrival the kernel has stamped
  base::Duration arrival{};   ///< from their stamps to our reads, in all
};

/// Finds the processor core on which a link's thread forwards at the least cost.
///
/// A thread that sleeps between packets is woken a thousand times a second. If it runs on another
/// core than the program that it hears or writes to, each packet has to wake an idle core: 35 to
/// 50 us in a virtual machine, where waking costs the sender, too, and still 5 to 100 us on bare
/// metal. The kernel's scheduler prefers any idle core to the one where the packet was made, and
/// leaves a thread there. So the thread tries the cores one after the other, some 30 packets each,
/// and stays where a packet costs clearly less than without a choice.
///
/// When packets become dear again, the program at the other end has probably moved: then the thread
/// tries the other cores.
///
/// The choice must not crowd out other programs. A thread that waits behind others or carries a
/// flood gives the choice back to the scheduler, and so does one that finds no cheap core or would
/// have to follow too often. It tries again after a pause, which grows while trials lead nowhere.
///
/// Cost of a packet: processor time, and the time until the thread runs: from the kernel's stamp
/// where packets have one, else as long as the scheduler has queued the thread.
class CoreSeeker {
 public:
  /// A thread that seldom runs gains little, one that often runs needs a core of its own.
  static constexpr double kLeastRate_hz = 100;
  static constexpr double kMostRate_hz = 5000;
  static constexpr double kMostLoad = 0.3;  ///< share of a core
  /// Behind others for longer: the core is busy.
  static constexpr base::Duration kMostQueued = std::chrono::microseconds(50);
  /// Worth a choice: less than this share of the cost without one.
  static constexpr double kWorthwhile = 0.8;
  static constexpr base::Duration kShortestPause = std::chrono::milliseconds(250);
  static constexpr base::Duration kLongestPause = std::chrono::seconds(128);
  /// A thread settled for so long begins again with the shortest pause.
  static constexpr base::Duration kLasting = std::chrono::seconds(5);
  /// More are not tried.
  static constexpr std::size_t kMostCores = 16;

  /// @param cores  that the thread may run on; fewer than two: there is nothing to seek
  explicit CoreSeeker(std::vector<int> cores);

  bool seeks() const { return cores_.size() > 1; }
  /// Turns until the next call of take().
  std::uint64_t sample_turns() const;
  /// The figures since the last call.
  void take(const CoreSample& sample, base::RunTime now);
  /// A flood begins: the scheduler chooses at once.
  void release(base::RunTime now);
  /// The one core to run on from now on; nothing: any.
  std::optional<int> core() const;
  /// Whether it has chosen, and tries no more.
  bool settled() const { return state_ == State::kSettled; }
  /// Cost of a packet on the core where it settled.
  base::Duration cost() const { return best_cost_; }
  /// Cost of a packet before, on the scheduler's choice.
  base::Duration free_cost() const { return free_cost_; }

 private:
  enum class State { kFree, kTrying, kSettled };

  static base::Duration cost_of(const CoreSample& sample);
  static bool fits(const CoreSample& sample, base::Duration most_queued);
  void begin_trial(base::RunTime now);
  void try_others(base::Duration cost, base::RunTime now);
  void try_next(std::size_t at);
  void go_on(base::Duration cost);
  void judge(base::RunTime now);
  void watch(base::Duration cost, base::RunTime now);
  void give_up(base::RunTime now);

  std::vector<int> cores_;
  State state_ = State::kFree;
  bool skip_ = true;  ///< the next sample: the thread has just moved
  std::size_t at_ = 0;
  std::optional<std::size_t> known_;  ///< not tried again: its present cost is known
  std::size_t best_ = 0;
  base::Duration free_cost_{};
  base::Duration best_cost_{};
  int dear_ = 0;  ///< samples in a row that cost more than when it settled
  base::RunTime trial_began_{};
  base::RunTime settled_at_{};
  base::RunTime next_trial_{};
  base::Duration pause_ = kShortestPause;
};

}  // namespace cas::casd

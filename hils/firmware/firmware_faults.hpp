// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/firmware/flight_deck.hpp"
#include "hils/flight/bench_fault.hpp"

namespace cas::hils {

/// Plays the faults of the bench in a flight of stock firmware, and knows when the vehicles may be
/// silent because of one.
class FirmwareFaults {
 public:
  /// Called before casd ends, and forgets its counters and calls.
  using BeforeCasdEnds = std::function<void()>;
  /// Called when the radio is lost, or back: the sticks stop, or go on.
  using LoseSticks = std::function<void(bool lost)>;

  /// @param deck  outlives the faults
  FirmwareFaults(FlightDeck& deck, BeforeCasdEnds before_casd_ends, LoseSticks lose_sticks)
      : deck_(deck),
        before_casd_ends_(std::move(before_casd_ends)),
        lose_sticks_(std::move(lose_sticks)) {}

  /// Begins or ends a fault of the script. A pause is over when it returns.
  /// @throws RunStopped, base::rpc::CallError
  void play(const BenchFaultScript& script, const BenchFault& fault, bool begins);
  /// After the flight: casd is there again.
  void end_restart() { restart(false); }

  bool casd_is_away() const { return casd_is_away_; }
  /// Whether a vehicle that casd does not hear is silent because of a fault: while one lasts that
  /// keeps casd from hearing it, and for 30 s of real time after it.
  bool excuses_silence(base::RunTime now) const;

 private:
  void pause(base::Duration wall);
  void restart(bool begins);
  void cut(const std::string& link, bool begins);
  void reload();
  void remove_cut_links();
  void remove(const std::string& link);
  void note_outage(bool begins);

  FlightDeck& deck_;
  BeforeCasdEnds before_casd_ends_;
  LoseSticks lose_sticks_;
  bool casd_is_away_ = false;
  std::vector<std::string> cut_links_;  ///< one for each cut under way
  int outages_ = 0;                     ///< under way
  base::RunTime excused_until_{};       ///< once none is
};

}  // namespace cas::hils

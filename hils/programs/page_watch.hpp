// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/flight/flight_loop.hpp"
#include "hils/measure/flight_changes.hpp"
#include "hils/programs/flown_simulator.hpp"
#include "hils/programs/live_run.hpp"

namespace cas::hils {

/// What others do to a flight of programs: calls of clients at casd and the simulator, and with a
/// page its figures, its faults and its pauses. Whoever controls the vehicles uses it in each turn.
///
///   before_steps() -> steps -> after_steps() -> ... -> finish()
class PageWatch {
 public:
  /// casd, or nullptr while it is away.
  using Casd = std::function<base::rpc::Client*()>;

  /// @param live  nullptr: the flight has no page. All outlive the watch.
  PageWatch(LiveRun* live, FlownSimulator& simulator, Casd casd)
      : live_(live), simulator_(simulator), casd_(std::move(casd)) {}

  /// A paused run waits for ever: names the caller, and resumes the run if casweb has ended
  /// meanwhile.
  void before_steps();
  /// Sends the figures that the page shows, and takes the faults that it orders.
  /// @param begin  a fault of a line
  void after_steps(Flight& flight, base::SimTime now, const LiveRun::BeginFault& begin);
  /// casd is about to end, and forgets its calls.
  void before_casd_ends();
  /// The flight is over. @return all calls by others
  std::vector<OutsideCall> finish();

 private:
  std::vector<OutsideCall> calls();

  LiveRun* live_;
  FlownSimulator& simulator_;
  Casd casd_;
  std::vector<OutsideCall> earlier_;  ///< to casds that have ended
  bool said_paused_ = false;
};

}  // namespace cas::hils

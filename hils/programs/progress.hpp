// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// How a run keeps to the clock: "1.00x", after late steps "1.00x, 3 late".
std::string pace_words(double real_time_factor, std::optional<std::uint64_t> late_steps = {});

/// The step under way, the pace of the run, the vehicle's estimated position (north, east, up in
/// m), and the state of the stream in words; cut to the width from the right.
///
/// @param columns  most characters that the line may have
std::string progress_line(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
                          const std::string& pace, const std::string& stream, std::size_t columns);

/// The same with the step's number, for where there is no terminal: "hils: step 3 of 8, ...".
std::string plain_progress_line(base::SimTime now, const FlightPlan& plan,
                                const VehicleReport& vehicle, const std::string& pace);

/// One line on a terminal that is rewritten while the run goes on. Where standard error is no
/// terminal a line of its own every ten seconds, the first after two.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Whether the line is shown: else its data need not be collected.
  bool shows() const { return terminal_ || base::steady_now() >= next_plain_; }
  /// Shows progress_line(), drawn again only when it has changed; or plain_progress_line() when it
  /// is due.
  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
            const std::string& pace, const std::string& stream = {});
  /// Takes the line away.
  void clear();

 private:
  bool terminal_;
  base::RunTime next_plain_;
  std::string shown_;  ///< empty: no line is there
};

}  // namespace cas::hils

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

/// The step under way, how the run keeps to the clock, where the vehicle takes itself to be (north,
/// east, up in m), and how the stream does in words; of these from the left what fits.
///
/// @param columns  most characters that the line may have
std::string progress_line(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
                          const std::string& pace, const std::string& stream, std::size_t columns);

/// One line on a terminal that is rewritten while the run goes on; nothing where standard error is
/// no terminal.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Whether anybody looks: else nothing needs to be found out for it.
  bool shows() const { return terminal_; }
  /// Shows progress_line(), drawn again only when it has changed.
  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
            const std::string& pace, const std::string& stream = {});
  /// Takes the line away.
  void clear();

 private:
  bool terminal_;
  std::string shown_;  ///< empty: no line is there
};

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "base/time/clock.hpp"
#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// The step under way, where the vehicle takes itself to be (north, east, up in m), and how the
/// stream does in words; of these from the left what fits.
///
/// @param columns  most characters that the line may have
std::string progress_line(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
                          double real_time_factor, const std::string& stream, std::size_t columns);

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
            double real_time_factor, const std::string& stream = {});
  /// Takes the line away.
  void clear();

 private:
  bool terminal_;
  std::string shown_;  ///< empty: no line is there
};

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/clock.hpp"
#include "hils/flight_plan.hpp"

namespace cas::hils {

/// One line on a terminal that is rewritten while the run goes on; nothing where standard error is
/// no terminal.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows the step under way and how the vehicle does.
  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
            double real_time_factor);
  /// Takes the line away.
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
};

}  // namespace cas::hils

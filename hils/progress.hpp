// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

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

  /// Whether anybody looks: else nothing needs to be found out for it.
  bool shows() const { return terminal_; }
  /// Shows the step under way, how the vehicle does, and how the stream does in words.
  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
            double real_time_factor, const std::string& stream = {});
  /// Takes the line away.
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
};

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/station/services.hpp"
#include "casd/station/vehicle_state.hpp"

namespace cas::casd {

/// The parameter that holds the height of a takeoff: PX4's MIS_TAKEOFF_ALT, ArduPlane's TKOFF_ALT.
/// casd writes it for a takeoff and afterwards restores the old value. Pure.
class TakeoffHeight {
 public:
  /// @param params  of the vehicle; outlives this
  /// @param state   of the vehicle; outlives this
  TakeoffHeight(ParamExchange& params, const VehicleState& state)
      : params_(params), state_(state) {}

  /// @param clock  read now, and when the vehicle has answered
  void write(double altitude_m, std::function<base::RunTime()> clock, Done done);
  /// Restores the old value, unless nothing was written or another has set the parameter since.
  void put_back(base::RunTime now);
  /// Another has set the parameter: that value stays.
  void keep() { before_.reset(); }
  std::string parameter() const;

  /// When it was last written.
  base::RunTime written() const { return written_; }
  bool is_putting_back() const { return putting_back_; }
  /// Called with the outcome of the restoration that is under way.
  void after_putting_back(Done then) { then_.push_back(std::move(then)); }

 private:
  ParamExchange& params_;
  const VehicleState& state_;
  std::optional<double> before_;  ///< the value to restore
  base::RunTime written_{};
  bool putting_back_ = false;
  std::vector<Done> then_;
};

}  // namespace cas::casd

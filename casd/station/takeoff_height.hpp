// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/station/services.hpp"

namespace cas::casd {

/// PX4's default height of a takeoff, MIS_TAKEOFF_ALT: casd writes it for a takeoff and afterwards
/// restores the old value. Pure.
class TakeoffHeight {
 public:
  static constexpr std::string_view kParameter = "MIS_TAKEOFF_ALT";

  /// @param params  of the vehicle; outlives this
  explicit TakeoffHeight(ParamExchange& params) : params_(params) {}

  /// @param clock  read now, and when the vehicle has answered
  void write(double altitude_m, std::function<base::RunTime()> clock, Done done);
  /// Restores the old value, unless nothing was written or another has set the parameter since.
  void put_back(base::RunTime now);
  /// Another has set the parameter: that value stays.
  void keep() { before_.reset(); }

  /// When it was last written.
  base::RunTime written() const { return written_; }
  bool is_putting_back() const { return putting_back_; }
  /// Called with the outcome of the restoration that is under way.
  void after_putting_back(Done then) { then_.push_back(std::move(then)); }

 private:
  ParamExchange& params_;
  std::optional<double> before_;  ///< the value to restore
  base::RunTime written_{};
  bool putting_back_ = false;
  std::vector<Done> then_;
};

}  // namespace cas::casd

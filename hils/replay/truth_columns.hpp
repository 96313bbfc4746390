// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

namespace cas::hils {

/// The true motion in a record: the columns of truth.csv (t, x, y, z, vx, vy, vz in W; roll, pitch,
/// yaw, p, q, r of D), then the speed of each rotor and the deflection of each control surface, at
/// 50 Hz.
class TruthColumns {
 public:
  /// Columns before the first rotor.
  static constexpr std::size_t kMotion = 13;

  /// @param row  time in s first, and at least kMotion values; the first row sets the number of
  ///             rotors, and a later row without one of them has 0 there
  /// @param deflections  of the control surfaces, rad; of the same number in each row
  void add(std::span<const double> row, std::span<const double> deflections = {});

  /// A series for each column; null without any row.
  nlohmann::ordered_json json() const;

 private:
  std::vector<std::vector<double>> columns_;
  std::vector<std::vector<double>> surfaces_;
  double next_s_ = 0;
};

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "hils/measure/clock_map.hpp"

namespace cas::hils {

/// Place and heading as results name them: x north, y east, z up in m, yaw in N in rad.
struct Pose {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  double roll_rad = 0;
  double pitch_rad = 0;
  double yaw_rad = 0;
};

/// A pose at a moment of simulated time.
struct PoseSample {
  std::int64_t time_us = 0;
  Pose pose{};
  std::array<double, 4> omega_rad_s{};  ///< rotors 1..4; zero in an estimate
};

/// Root mean squares of the distance from a reference, per axis.
struct RmsFigures {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  double yaw_rad = 0;
  std::uint64_t samples = 0;
};

/// Truth as the recorder plugin writes it (truth.csv). @throws
/// base::ConfigError naming file and line
std::vector<PoseSample> read_truth(const std::filesystem::path& file);

/// The controller's own estimate out of a flight log (tlog): each LOCAL_POSITION_NED of `system`
/// with the newest ATTITUDE before it. `clock` leads from the log's clock to simulated time.
std::vector<PoseSample> read_estimate(const std::filesystem::path& tlog, std::uint8_t system,
                                      const ClockMap& clock);

/// Samples with begin <= time < end.
std::span<const PoseSample> between(std::span<const PoseSample> samples, std::int64_t begin_us,
                                    std::int64_t end_us);

/// Where the vehicle shall be at a moment, microseconds.
using ReferenceAt = std::function<Pose(std::int64_t time_us)>;
/// Deviations of the samples from a reference, which may move.
RmsFigures rms_about(std::span<const PoseSample> samples, const ReferenceAt& reference_at);

}  // namespace cas::hils

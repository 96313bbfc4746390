// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/flight_plan.hpp"

namespace cas::hils {

/// Root mean squares of the distance from a reference, per axis.
struct RmsFigures {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  double yaw_rad = 0;
  std::uint64_t samples = 0;
};

/// A component of RmsFigures, under its key in summary.json and in limits.
struct RmsAxis {
  std::string_view key;
  std::string_view unit;
  double RmsFigures::*member;
};
inline constexpr std::array<RmsAxis, 4> kRmsAxes{{{"x_m", "m", &RmsFigures::x_m},
                                                  {"y_m", "m", &RmsFigures::y_m},
                                                  {"z_m", "m", &RmsFigures::z_m},
                                                  {"yaw_rad", "rad", &RmsFigures::yaw_rad}}};

/// Maps the clock of a flight log to simulated time: pairs of both, read together now and then,
/// with straight lines between them. Microseconds.
class ClockMap {
 public:
  /// Adds a moment, read on both clocks; moments come in order.
  void add(std::int64_t log_us, std::int64_t sim_us);
  /// Simulated time at a moment of the log; beyond the ends the clocks run alike.
  std::int64_t to_sim_us(std::int64_t log_us) const;
  bool empty() const { return pairs_.empty(); }

 private:
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs_;  ///< log, simulated
};

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
  std::array<double, 3> v_m_s{};  ///< north, east, up; zero in an estimate
  int rotors = 0;                 ///< none in an estimate
  /// Rotors 1 to `rotors`; zero beyond.
  std::array<double, base::kMaxRotors> omega_rad_s{};
  std::optional<double> airspeed_m_s{};  ///< true; of a vehicle with a pitot tube
};

/// Simulated time as PoseSample has it, rounded down.
constexpr std::int64_t to_microseconds(base::SimTime time) {
  return static_cast<std::int64_t>(base::to_time_usec(time));
}

/// Adds up distances from a reference, sample by sample.
class RmsSums {
 public:
  void add(const Pose& pose, const Pose& reference);
  /// All zero without a sample.
  RmsFigures figures() const;

 private:
  RmsFigures squares_;
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

/// Reference pose of the vehicle at a moment, microseconds.
using ReferenceAt = std::function<Pose(std::int64_t time_us)>;
/// Deviations of the samples from a reference, which may move.
RmsFigures rms_about(std::span<const PoseSample> samples, const ReferenceAt& reference_at);

/// Farthest distance of the samples from a reference.
double peak_error_m(std::span<const PoseSample> samples, const ReferenceAt& reference_at);
/// How far the mean height of the samples is from that of the reference.
double height_error_m(std::span<const PoseSample> samples, const ReferenceAt& reference_at);
/// Farthest horizontal distance from the first sample.
double drift_m(std::span<const PoseSample> samples);
/// How much the rotors are made to work: root mean square of their accelerations from sample to
/// sample, over all of them, rad/s^2. A hover without noise has 0.
double rotor_activity_rad_s2(std::span<const PoseSample> samples);

/// Reference pose at a moment of a step: the place of the last takeoff or goto, or the
/// point of the trajectory under way. North, east, up from the start; a trajectory is taken to have
/// begun when the vehicle confirmed it.
Pose reference_at(const Stage& stage, std::int64_t time_us);
/// The same in the vehicle's own frame, where its estimate has it.
Pose reference_in_estimate(const Stage& stage, std::int64_t time_us);
/// The same in the axes of the truth: the plan's places count from where the vehicle stood.
/// @param stage  must outlive the returned function
ReferenceAt reference_in_truth(const Stage& stage, std::span<const PoseSample> truth);

}  // namespace cas::hils

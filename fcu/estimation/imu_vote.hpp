// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "base/time/clock.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/estimation/sensor_health.hpp"

namespace cas::fcu {

/// Why a sensor is not flown by.
enum class VoteCause : std::uint8_t {
  kNone,
  kSilent,     ///< no samples
  kStuck,      ///< its values repeat exactly
  kDisagrees,  ///< it reads something else than the others, or than the estimate
};

/// From now on another sensor of a kind is flown by.
struct VoteSwitch {
  int from = 0;  ///< from 0, as `id` on the wire
  int to = 0;
  VoteCause cause = VoteCause::kNone;
};

/// Chooses one of up to three IMUs.
///
/// The one in use stays in use until it falls silent (0.1 s), sticks (100 samples) or, with three
/// that live, reads for 0.1 s something else than the median of all: its difference, smoothed over
/// 0.1 s, is more than 5 deg/s or 1 m/s^2. Then comes the first that has none of these faults; one
/// that is free of faults for 5 s may be chosen again. Two that disagree are not told apart. Levers
/// between the IMUs are not corrected: a turn of 5 rad/s at 3 cm is 0.75 m/s^2.
class ImuVote {
 public:
  static constexpr int kMost = 3;

  /// Notes a sample. @param at  the IMU, from 0
  void on_sample(int at, const ImuInput& imu);
  /// Whether there is more than the first.
  bool several() const { return several_; }
  /// Judges the IMUs by their samples so far.
  /// @return the newest sample of the one in use; nullptr if it has none since the last call
  const ImuInput* choose(base::SimTime now);
  /// The change that choose() has just made, once.
  std::optional<VoteSwitch> take_switch();
  /// The one in use, from 0.
  int used() const { return used_; }
  VoteCause fault(int at) const { return imus_[static_cast<std::size_t>(at)].fault; }

 private:
  struct Imu {
    ImuInput newest;
    bool seen = false;
    bool is_new = false;
    StuckValue gyro, accel;
    Eigen::Vector3d gyro_off = Eigen::Vector3d::Zero();   ///< from the median, smoothed, rad/s
    Eigen::Vector3d accel_off = Eigen::Vector3d::Zero();  ///< the same, m/s^2
    base::SimTime agrees;                                 ///< when it last agreed
    base::SimTime faulty;                                 ///< when it last had a fault
    VoteCause fault = VoteCause::kNone;
  };

  bool lives(const Imu& imu, base::SimTime now) const;
  void compare(base::SimTime now);
  VoteCause judge(const Imu& imu, base::SimTime now) const;

  std::array<Imu, kMost> imus_{};
  std::optional<base::SimTime> compared_;
  std::optional<VoteSwitch> switch_;
  int used_ = 0;
  bool several_ = false;
};

}  // namespace cas::fcu

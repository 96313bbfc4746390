// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/imu_vote.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/angles.hpp"

namespace cas::fcu {
namespace {

constexpr double kSilent_s = 0.1;
constexpr double kSmoothing_s = 0.1;
constexpr double kDisagreement_s = 0.1;
constexpr double kGyroLimit_rad_s = 5 * base::kRadPerDeg;  // above the turn-on bias of cheap parts
constexpr double kAccelLimit_m_s2 = 1.0;
constexpr double kForgiven_s = 5;

double median(double a, double b, double c) {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

Eigen::Vector3d median(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                       const Eigen::Vector3d& c) {
  return {median(a.x(), b.x(), c.x()), median(a.y(), b.y(), c.y()), median(a.z(), b.z(), c.z())};
}

}  // namespace

void ImuVote::on_sample(int at, const ImuInput& imu) {
  if (at < 0 || at >= kMost) return;
  Imu& own = imus_[static_cast<std::size_t>(at)];
  own.newest = imu;
  own.is_new = true;
  if (!std::exchange(own.seen, true)) own.agrees = imu.time;
  own.gyro.update(imu.gyro_D);
  own.accel.update(imu.accel_D);
  several_ = several_ || at > 0;
}

bool ImuVote::lives(const Imu& imu, base::SimTime now) const {
  return imu.seen && base::to_seconds(now - imu.newest.time) <= kSilent_s && !imu.gyro.stuck() &&
         !imu.accel.stuck() && imu.newest.gyro_D.allFinite() && imu.newest.accel_D.allFinite();
}

/// Takes the newest samples of three that live into their differences from the median.
void ImuVote::compare(base::SimTime now) {
  const double dt = compared_ ? base::to_seconds(now - *compared_) : 0.0;
  compared_ = now;
  const bool all = std::ranges::all_of(imus_, [&](const Imu& imu) { return lives(imu, now); });
  if (!all) {
    for (Imu& imu : imus_) imu.agrees = now;
    return;
  }
  const auto& [a, b, c] = imus_;
  const Eigen::Vector3d gyro = median(a.newest.gyro_D, b.newest.gyro_D, c.newest.gyro_D);
  const Eigen::Vector3d accel = median(a.newest.accel_D, b.newest.accel_D, c.newest.accel_D);
  const double share = std::clamp(dt / kSmoothing_s, 0.0, 1.0);
  for (Imu& imu : imus_) {
    imu.gyro_off += share * (imu.newest.gyro_D - gyro - imu.gyro_off);
    imu.accel_off += share * (imu.newest.accel_D - accel - imu.accel_off);
    const bool off =
        imu.gyro_off.norm() > kGyroLimit_rad_s || imu.accel_off.norm() > kAccelLimit_m_s2;
    if (!off) imu.agrees = now;
  }
}

VoteCause ImuVote::judge(const Imu& imu, base::SimTime now) const {
  if (!imu.seen || base::to_seconds(now - imu.newest.time) > kSilent_s) return VoteCause::kSilent;
  if (imu.gyro.stuck() || imu.accel.stuck()) return VoteCause::kStuck;
  if (!lives(imu, now)) return VoteCause::kDisagrees;  // not numbers
  if (base::to_seconds(now - imu.agrees) > kDisagreement_s) return VoteCause::kDisagrees;
  return VoteCause::kNone;
}

const ImuInput* ImuVote::choose(base::SimTime now) {
  compare(now);
  for (Imu& imu : imus_) {
    const VoteCause cause = judge(imu, now);
    if (cause != VoteCause::kNone) imu.faulty = now;
    const bool forgiven = base::to_seconds(now - imu.faulty) > kForgiven_s;
    if (cause != VoteCause::kNone || forgiven || !imu.seen) imu.fault = cause;
  }
  const VoteCause cause = imus_[static_cast<std::size_t>(used_)].fault;
  if (cause != VoteCause::kNone) {
    const auto good = std::ranges::find(imus_, VoteCause::kNone, &Imu::fault);
    if (good != imus_.end()) {
      const int to = static_cast<int>(good - imus_.begin());
      switch_ = VoteSwitch{.from = used_, .to = to, .cause = cause};
      used_ = to;
    }
  }
  const Imu& used = imus_[static_cast<std::size_t>(used_)];
  const bool is_new = used.is_new;
  for (Imu& imu : imus_) imu.is_new = false;
  return is_new ? &used.newest : nullptr;
}

std::optional<VoteSwitch> ImuVote::take_switch() { return std::exchange(switch_, std::nullopt); }

}  // namespace cas::fcu

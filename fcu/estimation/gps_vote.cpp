// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/gps_vote.hpp"

#include <algorithm>
#include <utility>

namespace cas::fcu {
namespace {

constexpr double kLeastSilence_s = 0.6;
constexpr double kSilentPeriods = 3;
constexpr int kFarInARow = 2;

bool silent(const std::optional<base::SimTime>& last, double period_s, base::SimTime now) {
  if (!last) return true;
  return base::to_seconds(now - *last) > std::max(kLeastSilence_s, kSilentPeriods * period_s);
}

}  // namespace

void GpsVote::on_fix(int at, const Fix& fix) {
  if (at < 0 || at >= kMost) return;
  several_ = several_ || at > 0;
  Receiver& own = receivers_[static_cast<std::size_t>(at)];
  if (fix.has_fix && own.repeated.accept(fix.digits)) {
    if (own.last) own.period_s = base::to_seconds(fix.heard - *own.last);
    own.last = fix.heard;
    own.off = fix.off.value_or(0);
    own.far = own.off > 1 ? own.far + 1 : 0;
  }
  if (!several_) return;
  const int other = 1 - used_;
  const Receiver& in_use = receivers_[static_cast<std::size_t>(used_)];
  const Receiver& in_reserve = receivers_[static_cast<std::size_t>(other)];
  const VoteCause cause = judge(in_use, in_reserve, fix.heard);
  if (cause == VoteCause::kNone) return;
  switch_ = VoteSwitch{.from = used_, .to = other, .cause = cause};
  used_ = other;
}

/// Fault of the receiver in use; none while the other is silent.
VoteCause GpsVote::judge(const Receiver& own, const Receiver& other, base::SimTime now) const {
  if (silent(other.last, other.period_s, now)) return VoteCause::kNone;
  if (silent(own.last, own.period_s, now)) {
    return own.repeated.frozen() ? VoteCause::kStuck : VoteCause::kSilent;
  }
  const bool far = own.far >= kFarInARow && other.off <= 0.5 * own.off;
  return far ? VoteCause::kDisagrees : VoteCause::kNone;
}

std::optional<VoteSwitch> GpsVote::take_switch() { return std::exchange(switch_, std::nullopt); }

}  // namespace cas::fcu

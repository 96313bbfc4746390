// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/scripted_fence.hpp"

#include <fmt/format.h>

#include <bit>
#include <utility>

#include "mavlink/common/param_request_read.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/param_value.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "tests/firmware/scripted_px4.hpp"

namespace cas::test {

namespace mv = mavlink::common;

namespace {

/// PX4 v1.12.0: GEOFENCE_CHECK_INTERVAL_US. ArduCopter 4.5 checks in its three_hz_loop.
constexpr base::Duration kPx4Period = std::chrono::milliseconds(200);
/// PX4 v1.12.0 looks ahead by the way on which it stops at the worst
/// (computeBrakingDistanceMultirotor): flown at 1 m/s it turned so far inside its fence.
constexpr double kLooksAhead_m = 8;
constexpr base::Duration kCopterPeriod = std::chrono::milliseconds(333);

// Bits of FENCE_TYPE.
constexpr int kCeiling = 1;
constexpr int kCircle = 2;

}  // namespace

/// Their defaults: PX4's are off by distances of 0, ArduCopter's by FENCE_ENABLE.
ScriptedFence::ScriptedFence(FenceStyle style, FenceManner manner)
    : style_(style), manner_(manner) {
  if (is_px4()) {
    params_ = {{"GF_ACTION", {2, true}}, {"GF_MAX_HOR_DIST", {0}}, {"GF_MAX_VER_DIST", {0}}};
  } else {
    params_ = {{"FENCE_ENABLE", {0, true}},
               {"FENCE_TYPE", {7, true}},
               {"FENCE_ACTION", {1, true}},
               {"FENCE_RADIUS", {300}},
               {"FENCE_ALT_MAX", {100}}};
  }
}

bool ScriptedFence::on_packet(const mav::PacketView& packet, Channel& ground) {
  if (const auto read = mav::decode<mv::ParamRequestRead>(packet); read && read->param_index < 0) {
    const std::string name(mav::text(read->param_id));
    if (!params_.contains(name)) return false;
    answer(name, ground);
    return true;
  }
  const auto set = mav::decode<mv::ParamSet>(packet);
  if (!set) return false;
  const auto found = params_.find(std::string(mav::text(set->param_id)));
  if (found == params_.end()) return false;
  Param& param = found->second;
  const bool bytes = param.whole && is_px4();
  param.value =
      bytes ? std::bit_cast<std::int32_t>(set->param_value) : static_cast<double>(set->param_value);
  answer(found->first, ground);
  return true;
}

/// PX4 sends an integer's bytes, ArduPilot the number.
void ScriptedFence::answer(const std::string& name, Channel& ground) const {
  constexpr std::uint16_t kNoIndex = 0xFFFF;
  const Param& param = params_.at(name);
  mv::ParamValue message;
  mav::set_text(message.param_id, name);
  message.param_type = param.whole ? (is_px4() ? mv::MavParamType::kInt32 : mv::MavParamType::kInt8)
                                   : mv::MavParamType::kReal32;
  message.param_value = param.whole && is_px4()
                            ? std::bit_cast<float>(static_cast<std::int32_t>(param.value))
                            : static_cast<float>(param.value);
  message.param_count = 1;
  message.param_index = kNoIndex;
  ground.send(message);
}

bool ScriptedFence::is_outside(const Eigen::Vector3d& p_home_N) const {
  const double far_m = p_home_N.head<2>().norm();
  const double high_m = -p_home_N.z();
  if (is_px4()) {
    const double most_far_m = param("GF_MAX_HOR_DIST");
    const double ahead_m = style_ == FenceStyle::kPx4_1_12 ? kLooksAhead_m : 0;
    const double most_high_m = param("GF_MAX_VER_DIST");
    return (most_far_m > 0 && far_m + ahead_m > most_far_m) ||
           (most_high_m > 0 && high_m > most_high_m);
  }
  const int type = static_cast<int>(param("FENCE_TYPE"));
  if (param("FENCE_ENABLE") == 0) return false;
  return ((type & kCircle) != 0 && far_m >= param("FENCE_RADIUS")) ||
         ((type & kCeiling) != 0 && high_m >= param("FENCE_ALT_MAX"));
}

ScriptedFence::Action ScriptedFence::action() const {
  const int value = static_cast<int>(param(is_px4() ? "GF_ACTION" : "FENCE_ACTION"));
  if (is_px4()) {
    return value == 2   ? Action::kHold
           : value == 3 ? Action::kReturn
           : value == 5 ? Action::kLand
                        : Action::kNone;
  }
  return value == 1   ? Action::kReturn
         : value == 2 ? Action::kLand
         : value == 4 ? Action::kHold
                      : Action::kNone;
}

ScriptedFence::Action ScriptedFence::update(const Eigen::Vector3d& p_home_N, base::RunTime now) {
  if (manner_ == FenceManner::kNeverActs) return Action::kNone;
  if (checked_ && now - *checked_ < (is_px4() ? kPx4Period : kCopterPeriod)) return Action::kNone;
  checked_ = now;
  const bool was_outside = std::exchange(outside_, is_outside(p_home_N));
  const bool acts = is_px4() ? param("GF_ACTION") != 0 : true;
  if (!outside_ || was_outside || !acts) return Action::kNone;
  if (manner_ != FenceManner::kSaysNothing) say();
  return action();
}

/// The words of PX4 v1.12.0 (geofence.cpp, navigator_main.cpp), of PX4's main branch after v1.16
/// (geofenceCheck.cpp), and of ArduCopter before 4.6 (fence.cpp).
void ScriptedFence::say() {
  if (style_ == FenceStyle::kPx4_1_12) {
    texts_ += fmt::format("Maximum distance from home reached ({:.5f})\nApproaching on Geofence\n",
                          param("GF_MAX_HOR_DIST"));
  } else if (style_ == FenceStyle::kPx4_1_16) {
    texts_ += "Geofence: exceeding maximum distance to Home\n";
  } else {
    texts_ += "Fence Breached\n";
  }
}

std::string ScriptedFence::take_text() {
  const std::size_t end = texts_.find('\n');
  if (end == std::string::npos) return {};
  std::string text = texts_.substr(0, end);
  texts_.erase(0, end + 1);
  return text;
}

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/scripted_px4.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <sstream>
#include <utility>

#include "base/config/vehicle.hpp"
#include "mavlink_gen/runtime/crc.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

namespace mv = mavlink::common;

namespace {

// Groups of fields_updated: one counts only with all its bits.
constexpr std::uint32_t kAccelAndGyro = 0x003F;
constexpr std::uint32_t kMag = 0x01C0;
constexpr std::uint32_t kBaro = 0x1A00;
constexpr std::uint32_t kLockstepBuild = 1;
constexpr int kArmed = 128;
constexpr base::Duration kActuatorPeriod = std::chrono::milliseconds(5);  // 200 Hz at most
constexpr base::Duration kStreamPatience = std::chrono::seconds(1);
constexpr base::Duration kComesDown = std::chrono::milliseconds(340);  // a gap in hover, HITL

fcu::FcuConfig controller_config(const ScriptedPx4::Options& options) {
  fcu::FcuConfig config;
  config.vehicle = base::Vehicle::load(std::filesystem::path(cas::test::source_dir()) /
                                       "config/vehicles" / (options.vehicle + ".yaml"));
  config.system_id = options.system;
  config.sensors = config.vehicle.sensors;
  config.actuators = fcu::ActuatorMessage::kHilActuatorControls;
  config.control_rate_hz = 250;
  if (options.mode == Px4Mode::kHitl) config.stamp = fcu::StampMode::kArrival;
  return config;
}

template <class Flags>
bool has_all(Flags flags, std::uint32_t group) {
  return (static_cast<std::uint32_t>(flags) & group) == group;
}

}  // namespace

void Channel::forward(std::span<const std::uint8_t> packet) {
  std::vector<std::uint8_t> bytes(packet.begin(), packet.end());
  const mav::PacketView view = mav::view_packet(packet);
  const bool is_v1 = view.version == 1;
  bytes[is_v1 ? 2 : 4] = sequence_++;
  const std::size_t covered =
      (is_v1 ? mav::kHeaderBytesV1 : mav::kHeaderBytesV2) + view.payload.size();
  mav::Crc16 crc;
  crc.update(std::span<const std::uint8_t>(bytes).subspan(1, covered - 1));
  crc.update(mv::table().find(view.message_id)->crc_extra);
  bytes[covered] = static_cast<std::uint8_t>(crc.value() & 0xFF);
  bytes[covered + 1] = static_cast<std::uint8_t>(crc.value() >> 8);
  send_(bytes);
}

void Channel::send_foreign(std::uint32_t message_id, std::uint8_t crc_extra,
                           std::span<const std::uint8_t> payload) {
  const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value & 0xFFU); };
  std::vector<std::uint8_t> bytes{0xFD,
                                  byte(static_cast<std::uint32_t>(payload.size())),
                                  0,
                                  0,
                                  sequence_++,
                                  self_.system,
                                  self_.component,
                                  byte(message_id),
                                  byte(message_id >> 8),
                                  byte(message_id >> 16)};
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  mav::Crc16 crc;
  crc.update(std::span<const std::uint8_t>(bytes).subspan(1));
  crc.update(crc_extra);
  bytes.push_back(byte(crc.value()));
  bytes.push_back(byte(crc.value() >> 8U));
  send_(bytes);
}

ScriptedPx4::ScriptedPx4(const Options& options, Channel::Send to_simulator,
                         Channel::Send to_ground)
    : options_(options),
      simulator_(std::move(to_simulator), options.system),
      ground_(std::move(to_ground), options.system),
      controller_(controller_config(options),
                  [this](std::span<const std::uint8_t> packet) { on_controller_packet(packet); }),
      as_itself_({options.system, 200}),
      fence_(options.release == Px4Release::k1_12 ? FenceStyle::kPx4_1_12 : FenceStyle::kPx4_1_16,
             options.fence) {
  if (options.release != Px4Release::k1_16) return;
  mv::CommandLong interval{.target_system = options.system,
                           .target_component = 1,
                           .command = mv::MavCmd::kSetMessageInterval,
                           .param1 = static_cast<float>(mv::EstimatorStatus::kId)};
  interval.param2 = 2e6;  // its default, until somebody asks for more
  controller_.on_bytes(as_itself_(interval), clock_);
}

void ScriptedPx4::restore_params(const std::string& lines) {
  std::istringstream in(lines);
  std::string name;
  for (double value = 0; in >> name >> value;) controller_.set_param(name, value);
}

void ScriptedPx4::on_connected() {
  mv::CommandLong interval{.command = mv::MavCmd::kSetMessageInterval};
  interval.param1 = 115;  // HIL_STATE_QUATERNION
  interval.param2 = 5000;
  if (options_.asks_for_truth) simulator_.send(interval);
  simulator_.send(mv::Heartbeat{.autopilot = mv::MavAutopilot::kPx4, .mavlink_version = 3});
}

void ScriptedPx4::on_simulator_bytes(std::span<const std::uint8_t> bytes, base::RunTime now) {
  from_simulator_.feed(bytes,
                       [&](const mav::PacketView& packet) { on_sensor_packet(packet, now); });
}

void ScriptedPx4::on_sensor_packet(const mav::PacketView& packet, base::RunTime now) {
  if (const auto sample = mav::decode<mv::HilSensor>(packet)) return on_sample(*sample, now);
  if (const auto fix = mav::decode<mv::HilGps>(packet)) on_fix(*fix, now);
  if (const auto truth = mav::decode<mv::HilStateQuaternion>(packet)) on_truth(*truth);
}

/// In software it goes into the log as ground truth; in HITL v1.12.0 and v1.16.1 lay it over their
/// own estimate.
void ScriptedPx4::on_truth(const mv::HilStateQuaternion& truth) {
  if (options_.mode == Px4Mode::kHitl) return complain("flies by the truth");
  ++truths_;
  truth_ = truth;
}

void ScriptedPx4::on_sample(const mv::HilSensor& sample, base::RunTime now) {
  const bool is_sitl = options_.mode == Px4Mode::kSitl;
  // 1.16 has an instance per id; only the first one moves the clock.
  if (options_.release == Px4Release::k1_16 && sample.id != 0) return;
  if (is_sitl) {
    const base::RunTime stamp{std::chrono::microseconds(sample.time_usec)};
    if (samples_ > 0 && stamp <= clock_) return complain("clock went back");
    clock_ = stamp;
  } else {
    clock_ = now;  // the stamp is ignored
  }
  ++samples_;
  last_sample_at_ = clock_;
  stream_lost_ = false;
  sensor_ = sample;
  disarm_in_time();
  die_in_time();
  if (has_all(sample.fields_updated, kMag)) {
    constexpr int kMost = 1000;
    look_for_repeats(mag_, std::array{sample.xmag, sample.ymag, sample.zmag}, kMost,
                     options_.release == Px4Release::k1_16 ? "MAG #0 failed: STALE!" : "");
  }
  if (has_all(sample.fields_updated, kBaro)) {
    constexpr int kMost = 100;
    look_for_repeats(baro_, std::array{sample.abs_pressure}, kMost,
                     options_.release == Px4Release::k1_16 ? "BARO #1 failed: STALE!"
                                                           : "BARO #0 failed: STALE!");
  }
  if (!has_all(sample.fields_updated, kAccelAndGyro)) return;
  controller_.on_bytes(sensors_in_(sample), clock_);
  if (is_sitl) answer_sample();
}

void ScriptedPx4::on_fix(const mv::HilGps& fix, base::RunTime) {
  ++fixes_;
  gps_ = fix;
  controller_.on_bytes(sensors_in_(fix), clock_);
}

void ScriptedPx4::look_for_repeats(Staleness& sensor, std::span<const float> values, int most,
                                   const char* complaint) {
  std::uint64_t digest = 0;
  for (const float value : values) digest = digest * 1000003 + std::bit_cast<std::uint32_t>(value);
  sensor.repeats = sensor.seen && digest == sensor.digest ? sensor.repeats + 1 : 0;
  sensor.digest = digest;
  sensor.seen = true;
  if (sensor.repeats == most && *complaint != 0) complain(complaint);
}

/// One HIL_ACTUATOR_CONTROLS a sample, once the outputs are up. Above the design rate of 250 Hz not
/// every sample triggers the rate loop, so some are never answered.
void ScriptedPx4::answer_sample() {
  constexpr base::Duration kRateLoop = std::chrono::microseconds(3900);
  if (samples_ <= static_cast<std::uint64_t>(options_.boot_samples)) return;
  if (answers_ > 0 && clock_ - last_answer_ < kRateLoop) return;
  last_answer_ = clock_;
  ++answers_;
  simulator_.send(outputs(clock_));
}

mv::HilActuatorControls ScriptedPx4::outputs(base::RunTime now) const {
  mv::HilActuatorControls outputs;
  const bool is_sitl = options_.mode == Px4Mode::kSitl;
  constexpr int kSitlMode = 1;   // custom
  constexpr int kHitlMode = 53;  // custom, auto, stabilize, HIL
  outputs.time_usec =
      static_cast<std::uint64_t>(now.time_since_epoch() / std::chrono::microseconds(1));
  outputs.mode =
      static_cast<mv::MavModeFlag>((is_sitl ? kSitlMode : kHitlMode) | (armed_ ? kArmed : 0));
  if (is_sitl) outputs.flags = static_cast<decltype(outputs.flags)>(kLockstepBuild);
  if (terminated_) {
    outputs.controls.fill(0);
  } else if (armed_) {
    std::copy(motors_.begin(), motors_.end(), outputs.controls.begin());
  } else if (!is_sitl && options_.release == Px4Release::k1_12) {
    outputs.controls.fill(-1.2F);
    std::fill_n(outputs.controls.begin(), motors_.size(), -0.1F);
  }
  return outputs;
}

void ScriptedPx4::tick(base::RunTime now) {
  if (options_.mode != Px4Mode::kHitl) return;
  clock_ = now;
  controller_.tick(now);
  if (samples_ > 0 && !stream_lost_ && now - last_sample_at_ > kStreamPatience) {
    stream_lost_ = true;
    complain("BARO #0 failed: TIMEOUT!");
  }
  watch_gap(now);
  if (now - last_answer_ < kActuatorPeriod) return;
  last_answer_ = std::max(last_answer_ + kActuatorPeriod, now - kActuatorPeriod);
  ++answers_;
  ground_.send(outputs(now));
}

/// Sends our controller's packets as PX4 would: outputs go to the simulator in PX4's form; in SITL
/// the HEARTBEAT has no HIL flag.
void ScriptedPx4::on_controller_packet(std::span<const std::uint8_t> bytes) {
  const mav::PacketView packet = mav::view_packet(bytes);
  if (const auto controls = mav::decode<mv::HilActuatorControls>(packet)) {
    armed_ = (static_cast<int>(controls->mode) & kArmed) != 0 || stays_armed();
    std::copy_n(controls->controls.begin(), motors_.size(), motors_.begin());
    return;
  }
  watch_fence(packet);
  note_readiness(packet);
  if (auto heartbeat = mav::decode<mv::Heartbeat>(packet)) {
    // v1.16.1 says MAV_STATE_UNINIT until it can be armed.
    const bool boots = options_.release == Px4Release::k1_16 && !ready_ && !armed_;
    if (boots) heartbeat->system_status = mv::MavState::kUninit;
    if (terminated_) heartbeat->system_status = mv::MavState::kFlightTermination;
    if (stays_armed()) heartbeat->base_mode |= mv::MavModeFlag::kSafetyArmed;
    if (options_.mode == Px4Mode::kSitl) return ground_.send(in_software(*heartbeat));
    if (stays_armed() || boots) return ground_.send(*heartbeat);
  }
  // An answer to its own command.
  const auto ack = mav::decode<mv::CommandAck>(packet);
  if (ack && ack->target_system == options_.system) return;
  if (lies(packet) || say_v1_12(packet) || say_v1_16(packet) || say_who_disarmed(packet)) return;
  ground_.forward(bytes);
}

void ScriptedPx4::note_readiness(const mav::PacketView& packet) {
  const auto status = mav::decode<mv::SysStatus>(packet);
  if (!status) return;
  ready_ = preflight_failure().empty() &&
           mv::has(status->onboard_control_sensors_health, mv::MavSysStatusSensor::kPrearmCheck);
}

mv::Heartbeat ScriptedPx4::in_software(mv::Heartbeat heartbeat) const {
  heartbeat.base_mode = static_cast<mv::MavModeFlag>(
      static_cast<int>(heartbeat.base_mode) & ~static_cast<int>(mv::MavModeFlag::kHilEnabled));
  if (armed_early_at_) heartbeat.base_mode |= mv::MavModeFlag::kSafetyArmed;
  if (options_.is_plane) heartbeat.type = mv::MavType::kFixedWing;
  if (options_.is_ardupilot) heartbeat.autopilot = mv::MavAutopilot::kArdupilotmega;
  return heartbeat;
}

/// Home is where it was armed.
void ScriptedPx4::watch_fence(const mav::PacketView& packet) {
  if (const auto state = mav::decode<mv::ExtendedSysState>(packet)) {
    in_air_ = state->landed_state == mv::MavLandedState::kInAir;
  }
  const auto position = mav::decode<mv::LocalPositionNed>(packet);
  if (!position) return;
  const Eigen::Vector3d p_N(position->x, position->y, position->z);
  if (!armed_) return home_N_.reset();
  if (!home_N_) home_N_ = p_N;
  const ScriptedFence::Action action = fence_.update(p_N - *home_N_, clock_);
  for (auto text = fence_.take_text(); !text.empty(); text = fence_.take_text()) {
    say(text, mv::MavSeverity::kCritical);
  }
  hold_return_or_land(action);
}

void ScriptedPx4::hold_return_or_land(ScriptedFence::Action action) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  mv::CommandLong command{.target_system = options_.system, .target_component = 1};
  switch (action) {
    case ScriptedFence::Action::kNone:
      return;
    case ScriptedFence::Action::kHold:
      command.command = mv::MavCmd::kDoSetMode;
      command.param1 = 1;
      command.param2 = 4;  // AUTO
      command.param3 = 3;  // LOITER
      break;
    case ScriptedFence::Action::kReturn:
      command.command = mv::MavCmd::kNavReturnToLaunch;
      break;
    case ScriptedFence::Action::kLand:
      command.command = mv::MavCmd::kNavLand;
      command.param4 = command.param5 = command.param6 = command.param7 = kNan;
      break;
  }
  controller_.on_bytes(as_itself_(command), clock_);
}

/// A gap in the samples disarms our controller, but not v1.16.1, which stays armed in TERMINATION.
bool ScriptedPx4::stays_armed() const {
  return terminated_ || (comes_down_ && clock_ - last_sample_at_ >= kComesDown);
}

/// HITL, v1.16.1: in hover a gap of 0.34 s in its samples brings it to the ground, one of 1 s into
/// TERMINATION.
void ScriptedPx4::watch_gap(base::RunTime now) {
  constexpr base::Duration kTerminates = std::chrono::seconds(1);
  const base::Duration gap = now - last_sample_at_;
  if (options_.release != Px4Release::k1_16 || !armed_ || gap < kComesDown) return;
  if (comes_down_ && gap >= kTerminates) {
    if (!std::exchange(terminated_, true)) complain("Flight termination active");
  } else if (in_air_ && !std::exchange(comes_down_, true)) {
    complain("angular velocity no longer valid");
    hold_return_or_land(ScriptedFence::Action::kLand);
  }
}

void ScriptedPx4::on_ground_bytes(std::span<const std::uint8_t> bytes, base::RunTime now) {
  from_ground_.feed(bytes, [&](const mav::PacketView& packet) {
    if (options_.mode == Px4Mode::kHitl && packet.source == mav::Source{1, 200}) {
      return on_sensor_packet(packet, now);
    }
    if (loses(packet) || twists(packet) || fence_.on_packet(packet, ground_)) return;
    if (!answers_its_own_way(packet)) controller_.on_packet(packet, clock_);
  });
}

/// Why PX4's preflight checks would not let it arm; empty when they would.
std::string ScriptedPx4::preflight_failure() const {
  constexpr double kCentimetres = 100;
  constexpr int kSatellites = 6;
  constexpr double kEph_m = 3;
  constexpr double kEpv_m = 5;
  if (!mag_.seen) return "Preflight Fail: Found 0 compass (required: 1)";
  if (!baro_.seen) return "Preflight Fail: barometer 0 missing";
  if (!gps_ || static_cast<int>(gps_->fix_type) < 3) return "Preflight Fail: No valid GPS";
  if (gps_->satellites_visible < kSatellites) return "Preflight Fail: not enough GPS Satellites";
  if (gps_->eph / kCentimetres > kEph_m) {
    return "Preflight Fail: GPS Horizontal Pos Error too high";
  }
  if (gps_->epv / kCentimetres > kEpv_m) return "Preflight Fail: GPS Vertical Pos Error too high";
  return {};
}

/// v1.12.0 in software: from 1.5 s on it lets one arm, and has its position after 10 s.
bool ScriptedPx4::lacks_position() const {
  constexpr base::RunTime kPosition{std::chrono::seconds(10)};
  return options_.release == Px4Release::k1_12 && options_.mode == Px4Mode::kSitl &&
         clock_ < kPosition;
}

bool ScriptedPx4::refuses_takeoff() const {
  const bool is_sitl = options_.mode == Px4Mode::kSitl;
  const bool stays = options_.stays_at_first && !has_disarmed_itself_;
  return lacks_position() || (is_sitl && (clock_ < options_.takes_off_after || stays));
}

bool ScriptedPx4::loses(const mav::PacketView& packet) {
  if (packet.message_id != mv::SetPositionTargetLocalNed::kId) return false;
  if (!first_setpoint_at_) first_setpoint_at_ = clock_;
  return options_.loses_setpoints_after &&
         clock_ - *first_setpoint_at_ > *options_.loses_setpoints_after;
}

/// Falsifies messages to a lying vehicle.
bool ScriptedPx4::twists(const mav::PacketView& packet) {
  const auto hear = [&](const auto& message) {
    mav::Encoder as_sender{packet.source};
    controller_.on_bytes(as_sender(message), clock_);
    return true;
  };
  if (options_.lie == Px4Lie::kIgnoresSetpoints) {
    auto setpoint = mav::decode<mv::SetPositionTargetLocalNed>(packet);
    if (!setpoint) return false;
    if (!first_setpoint_) first_setpoint_ = *setpoint;
    setpoint->x = first_setpoint_->x;
    setpoint->y = first_setpoint_->y;
    setpoint->vx = setpoint->vy = 0;
    return hear(*setpoint);
  }
  if (options_.lie == Px4Lie::kSkipsWaypoints) {
    if (const auto count = mav::decode<mv::MissionCount>(packet)) mission_items_ = count->count;
    auto item = mav::decode<mv::MissionItemInt>(packet);
    if (!item || item->seq + 1 == mission_items_ || !gps_) return false;
    item->x = gps_->lat;
    item->y = gps_->lon;
    return hear(*item);
  }
  auto command = mav::decode<mv::CommandLong>(packet);
  if (!command) return false;
  const bool lands =
      options_.lie == Px4Lie::kLandsInWords && command->command == mv::MavCmd::kNavLand;
  const bool returns =
      options_.lie == Px4Lie::kReturnsInWords && command->command == mv::MavCmd::kNavReturnToLaunch;
  if (!lands && !returns) return false;
  lies_now_ = true;
  acknowledge(command->command, packet.source, mv::MavResult::kAccepted);
  if (lands) return true;
  command->command = mv::MavCmd::kNavLand;
  return hear(*command);
}

/// Falsifies a lying vehicle's own messages.
bool ScriptedPx4::lies(const mav::PacketView& packet) {
  if (!lies_now_) return false;
  if (auto state = mav::decode<mv::ExtendedSysState>(packet);
      state && options_.lie == Px4Lie::kLandsInWords) {
    state->landed_state = mv::MavLandedState::kOnGround;
    ground_.send(*state);
    return true;
  }
  if (auto position = mav::decode<mv::LocalPositionNed>(packet);
      position && options_.lie == Px4Lie::kReturnsInWords) {
    position->x = position->y = 0;
    ground_.send(*position);
    return true;
  }
  return false;
}

void ScriptedPx4::disarm_in_time() {
  if (!armed_early_at_) return;
  const base::Duration armed = clock_ - *armed_early_at_;
  if (armed < options_.disarms_itself_after) return;
  has_disarmed_itself_ = true;
  disarm("auto preflight disarming");
}

void ScriptedPx4::die_in_time() {
  if (!armed_ || !options_.dies_after) return armed_at_.reset();
  if (!armed_at_) armed_at_ = clock_;
  if (clock_ - *armed_at_ < *options_.dies_after) return;
  std::fputs("scripted: a bug\n", stderr);
  std::abort();
}

void ScriptedPx4::disarm(const char* by) {
  armed_early_at_.reset();
  say(std::string("Disarmed by ") + by, mv::MavSeverity::kInfo);
}

/// PX4's texts for disarmings by our controller itself.
bool ScriptedPx4::say_who_disarmed(const mav::PacketView& packet) {
  const auto text = mav::decode<mv::Statustext>(packet);
  if (!text || options_.mode != Px4Mode::kSitl) return false;
  const bool has_landed = mav::text(text->text) == "Disarmed after landing";
  if (!has_landed && mav::text(text->text) != "Disarmed: no take-off") return false;
  disarm(has_landed ? "landing" : "auto preflight disarming");
  return true;
}

/// The commands that stock PX4 answers otherwise than our controller.
bool ScriptedPx4::answers_its_own_way(const mav::PacketView& packet) {
  const auto command = mav::decode<mv::CommandLong>(packet);
  if (!command) return false;
  if (command->target_system != 0 && command->target_system != options_.system) return true;
  const bool is_1_16 = options_.release == Px4Release::k1_16;
  switch (command->command) {
    case mv::MavCmd::kComponentArmDisarm:
      if (command->param1 == 0) return disarm_early(*command, packet.source);
      return refuse_to_arm(*command, packet.source) || arm_early(*command, packet.source);
    case mv::MavCmd::kDoFlighttermination:
      return command->param1 != 0 && disarm_early(*command, packet.source);
    case mv::MavCmd::kNavTakeoff:
      if (!refuses_takeoff()) return false;
      acknowledge(
          command->command, packet.source,
          options_.stays_at_first ? mv::MavResult::kAccepted : mv::MavResult::kTemporarilyRejected);
      return true;
    case mv::MavCmd::kDoSetMode: {
      // v1.16.1: accepted, then rejected, and the mode stays.
      constexpr float kPosctl = 3;
      if (!is_1_16 || command->param2 != kPosctl) return false;
      acknowledge(command->command, packet.source, mv::MavResult::kAccepted);
      acknowledge(command->command, packet.source, mv::MavResult::kTemporarilyRejected);
      return true;
    }
    case mv::MavCmd::kPreflightRebootShutdown:
      // v1.16.1 in software.
      if (!is_1_16 || options_.mode != Px4Mode::kSitl) return false;
      acknowledge(command->command, packet.source, mv::MavResult::kDenied);
      return true;
    default:
      return false;
  }
}

bool ScriptedPx4::refuse_to_arm(const mv::CommandLong& command, mav::Source from) {
  const bool is_1_16 = options_.release == Px4Release::k1_16;
  const std::string why = preflight_failure();
  if (why.empty() && (!is_1_16 || ready_)) return false;
  acknowledge(command.command, from, mv::MavResult::kTemporarilyRejected);
  // v1.16.1 tells of its receiver as EVENT alone.
  const bool is_told = !why.empty() && !(is_1_16 && why.find("GPS") != std::string::npos);
  if (is_told) complain(why);
  const char* const denied = is_1_16 ? "Arming denied: Resolve system health failures first"
                                     : "Arming denied! Check the preflight failures";
  if (why.empty()) {
    say(denied, mv::MavSeverity::kCritical);
  } else {
    complain(denied);
  }
  return true;
}

bool ScriptedPx4::arm_early(const mv::CommandLong& command, mav::Source from) {
  constexpr base::RunTime kLetsArm{std::chrono::milliseconds(1500)};
  if (!refuses_takeoff() || clock_ < kLetsArm) return false;
  if (!armed_early_at_) armed_early_at_ = clock_;
  acknowledge(command.command, from, mv::MavResult::kAccepted);
  return true;
}

bool ScriptedPx4::disarm_early(const mv::CommandLong& command, mav::Source from) {
  if (!armed_early_at_) return false;
  acknowledge(command.command, from, mv::MavResult::kAccepted);
  disarm("external command");
  return true;
}

void ScriptedPx4::acknowledge(mv::MavCmd command, mav::Source to, mv::MavResult result) {
  mv::CommandAck ack{.command = command,
                     .result = result,
                     .target_system = to.system,
                     .target_component = to.component};
  ground_.send(ack);
}

/// Differences of v1.12.0: no position before its time, and sensors that are healthy but not
/// "present".
bool ScriptedPx4::say_v1_12(const mav::PacketView& packet) {
  if (options_.release != Px4Release::k1_12) return false;
  if (packet.message_id == mv::HomePosition::kId) return lacks_position();
  if (auto status = mav::decode<mv::EstimatorStatus>(packet); status && lacks_position()) {
    status->flags = mv::EstimatorStatusFlags::kAttitude;
    ground_.send(*status);
    return true;
  }
  auto status = mav::decode<mv::SysStatus>(packet);
  if (!status) return false;
  using S = mv::MavSysStatusSensor;
  status->onboard_control_sensors_present &= ~(S::k3dGyro | S::k3dAccel);
  ground_.send(*status);
  return true;
}

/// Differences of v1.16.1, as recorded: "enabled" never has the bit of the arming checks, a sensor
/// that is missing is neither present nor healthy, CONST_POS_MODE is set while it stands, and there
/// is no SYSTEM_TIME.
bool ScriptedPx4::say_v1_16(const mav::PacketView& packet) {
  if (options_.release != Px4Release::k1_16) return false;
  if (packet.message_id == mv::SystemTime::kId) return true;
  if (auto status = mav::decode<mv::EstimatorStatus>(packet)) {
    if (!in_air_) status->flags |= mv::EstimatorStatusFlags::kConstPosMode;
    ground_.send(*status);
    return true;
  }
  auto status = mav::decode<mv::SysStatus>(packet);
  if (!status) return false;
  using S = mv::MavSysStatusSensor;
  S missing{};
  if (!mag_.seen) missing |= S::k3dMag;
  if (!baro_.seen) missing |= S::kAbsolutePressure;
  if (!gps_) missing |= S::kGps;
  status->onboard_control_sensors_present &= ~(missing | S::kPrearmCheck);
  status->onboard_control_sensors_enabled &= ~(S::kPrearmCheck | (missing & S::kGps));
  status->onboard_control_sensors_health &= ~(missing | (ready_ ? S{} : S::kPrearmCheck));
  ground_.send(*status);
  return true;
}

void ScriptedPx4::complain(const std::string& text) {
  if (std::find(complaints_.begin(), complaints_.end(), text) == complaints_.end()) {
    complaints_.push_back(text);
  }
  say(text, mv::MavSeverity::kCritical);
}

/// A text that does not fit into one STATUSTEXT is sent in chunks.
void ScriptedPx4::say(const std::string& text, mv::MavSeverity severity) {
  // v1.16.1 ends its texts with a tab.
  const std::string sent = text + (options_.release == Px4Release::k1_16 ? "\t" : "");
  mv::Statustext message{.severity = severity};
  if (sent.size() > message.text.size()) message.id = ++text_id_;
  for (std::size_t at = 0; at < sent.size(); at += message.text.size()) {
    message.text = {};
    std::copy_n(sent.begin() + static_cast<std::ptrdiff_t>(at),
                std::min(sent.size() - at, message.text.size()), message.text.begin());
    ground_.send(message);
    ++message.chunk_seq;
  }
}

}  // namespace cas::test

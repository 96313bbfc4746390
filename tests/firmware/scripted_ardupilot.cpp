// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/scripted_ardupilot.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <utility>

#include "base/config/vehicle.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/earth/magnetic_field.hpp"
#include "casd/station/vehicle_state.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

namespace mv = mavlink::common;

namespace {

constexpr std::uint32_t kStabilize = 0;
constexpr std::uint32_t kAuto = 3;
constexpr std::uint32_t kGuided = 4;
constexpr std::uint32_t kLoiter = 5;
constexpr std::uint32_t kRtl = 6;
constexpr std::uint32_t kLand = 9;
constexpr std::uint32_t kBrake = 17;
constexpr std::uint16_t kStoppedPwm = 1000;
constexpr std::uint16_t kArmedPwm = 1100;
constexpr std::uint32_t kPacketsPerSample = 3;
constexpr base::Geodetic kHome{47.397742, 8.545594, 488.0};
constexpr double kYear = 2026.5;

fcu::FcuConfig controller_config(const ScriptedArdupilot::Options& options) {
  fcu::FcuConfig config;
  config.vehicle = base::Vehicle::load(std::filesystem::path(cas::test::source_dir()) /
                                       "config/vehicles" / (options.vehicle + ".yaml"));
  config.system_id = options.system;
  config.sensors = config.vehicle.sensors;
  config.actuators = fcu::ActuatorMessage::kHilActuatorControls;
  return config;
}

/// Finds "key": behind `from` and reads `count` numbers in brackets, or one without.
bool read_numbers(std::string_view text, std::string_view key, std::span<double> values,
                  std::string& complaint) {
  const std::string quoted = "\"" + std::string(key) + "\":";
  const std::size_t found = text.find(quoted);
  if (found == std::string_view::npos) {
    complaint = "Failed to find key " + std::string(key);
    return false;
  }
  std::string rest(text.substr(found + quoted.size()));
  const char* at = rest.c_str();
  if (values.size() > 1 && *at++ != '[') {
    complaint = "Failed to parse Vector3f for " + std::string(key);
    return false;
  }
  for (double& value : values) {
    char* end = nullptr;
    value = std::strtod(at, &end);
    if (end == at) {
      complaint = "Failed to parse " + std::string(key);
      return false;
    }
    at = end + 1;
  }
  return true;
}

void put16(std::vector<std::uint8_t>& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

}  // namespace

std::optional<ParsedJson> parse_as_ardupilot(std::string_view text, std::string& complaint) {
  if (text.size() < 2 || text.front() != '\n' || text.back() != '\n') {
    complaint = "no newline before or after";
    return std::nullopt;
  }
  ParsedJson json;
  const std::size_t imu = text.find("\"imu\":");
  if (imu == std::string_view::npos) {
    complaint = "Failed to find section imu";
    return std::nullopt;
  }
  const bool whole = read_numbers(text, "timestamp", std::span(&json.timestamp, 1), complaint) &&
                     read_numbers(text.substr(imu), "gyro", json.gyro, complaint) &&
                     read_numbers(text.substr(imu), "accel_body", json.accel, complaint) &&
                     read_numbers(text, "position", json.position, complaint) &&
                     read_numbers(text, "velocity", json.velocity, complaint) &&
                     read_numbers(text, "quaternion", json.quaternion, complaint);
  return whole ? std::optional(json) : std::nullopt;
}

ScriptedArdupilot::ScriptedArdupilot(const Options& options, Channel::Send to_ground)
    : options_(options),
      ground_(std::move(to_ground), options.system),
      controller_(controller_config(options),
                  [this](std::span<const std::uint8_t> packet) { on_controller_packet(packet); }),
      projection_(kHome),
      fence_(FenceStyle::kCopter_4_5, options.fence) {}

std::uint16_t ScriptedArdupilot::pwm_us(int motor) const {
  if (!armed_) return kStoppedPwm;
  const double pwm = 1000.0 + 1000.0 * motors_[static_cast<std::size_t>(motor)];
  return static_cast<std::uint16_t>(std::lround(std::max<double>(pwm, kArmedPwm)));
}

std::vector<std::uint8_t> ScriptedArdupilot::servo_packet() const {
  constexpr std::uint16_t kMagic16 = 18458;
  constexpr std::uint16_t kMagic32 = 29569;
  std::vector<std::uint8_t> bytes;
  put16(bytes, options_.channels == 32 ? kMagic32 : kMagic16);
  put16(bytes, options_.frame_rate_hz);
  put16(bytes, static_cast<std::uint16_t>(frame_count_ & 0xFFFF));
  put16(bytes, static_cast<std::uint16_t>(frame_count_ >> 16));
  for (int i = 0; i < options_.channels; ++i) put16(bytes, i < 4 ? pwm_us(i) : kStoppedPwm);
  return bytes;
}

bool ScriptedArdupilot::on_text(std::string_view text) {
  const auto json = parse_as_ardupilot(text, complaint_);
  if (!json) return false;
  if (!newest_) first_timestamp_ = json->timestamp;
  newest_ = json;
  time_ = base::from_seconds(json->timestamp - first_timestamp_);
  for (int i = 0; i < 4; ++i) pwm_sum_ += pwm_us(i);
  pwm_samples_ += 4;
  if (frame_count_ % kPacketsPerSample == 0) feed_controller();
  ++frame_count_;
  return true;
}

/// SITL makes its own sensors out of the motion, with noise.
void ScriptedArdupilot::feed_controller() {
  constexpr std::uint32_t kSlowSensors = 12;  // packets: 100 Hz
  constexpr std::uint32_t kGps = 240;         // 5 Hz
  const ParsedJson& j = *newest_;
  const Eigen::Quaterniond q_ND(j.quaternion[0], j.quaternion[1], j.quaternion[2], j.quaternion[3]);
  const base::Geodetic place =
      projection_.to_geodetic({j.position[0], j.position[1], j.position[2]});
  const auto noisy = [this](double value, double stddev) {
    return static_cast<float>(value + stddev * noise_());
  };
  if (frame_count_ % kGps == 0) {
    mv::HilGps gps{.time_usec = static_cast<std::uint64_t>(time_.count() / 1000)};
    gps.fix_type = static_cast<decltype(gps.fix_type)>(3);
    gps.lat = static_cast<std::int32_t>(std::lround(place.lat_deg * 1e7));
    gps.lon = static_cast<std::int32_t>(std::lround(place.lon_deg * 1e7));
    gps.alt = static_cast<std::int32_t>(std::lround(place.alt_m * 1e3));
    gps.eph = gps.epv = 100;
    gps.vn = static_cast<std::int16_t>(std::lround(j.velocity[0] * 100));
    gps.ve = static_cast<std::int16_t>(std::lround(j.velocity[1] * 100));
    gps.vd = static_cast<std::int16_t>(std::lround(j.velocity[2] * 100));
    gps.satellites_visible = 10;
    controller_.on_bytes(into_controller_(gps), clock());
  }
  mv::HilSensor sensor{.time_usec = static_cast<std::uint64_t>(time_.count() / 1000) + 1,
                       .xacc = noisy(j.accel[0], 0.03),
                       .yacc = noisy(j.accel[1], 0.03),
                       .zacc = noisy(j.accel[2], 0.03),
                       .xgyro = noisy(j.gyro[0], 0.002),
                       .ygyro = noisy(j.gyro[1], 0.002),
                       .zgyro = noisy(j.gyro[2], 0.002)};
  std::uint32_t flags = 0x003F;
  if (frame_count_ % kSlowSensors == 0) {
    const Eigen::Vector3d field_D = q_ND.conjugate() * base::magnetic_field_N(place, kYear);
    sensor.xmag = noisy(field_D.x(), 0.002);
    sensor.ymag = noisy(field_D.y(), 0.002);
    sensor.zmag = noisy(field_D.z(), 0.002);
    sensor.abs_pressure = noisy(base::isa::pressure_pa(place.alt_m) / 100, 0.01);
    sensor.temperature = 12;
    flags |= 0x1BC0;
  }
  sensor.fields_updated = static_cast<decltype(sensor.fields_updated)>(flags);
  controller_.on_bytes(into_controller_(sensor), clock());
}

void ScriptedArdupilot::on_controller_packet(std::span<const std::uint8_t> bytes) {
  const mav::PacketView packet = mav::view_packet(bytes);
  if (const auto controls = mav::decode<mv::HilActuatorControls>(packet)) {
    armed_ = (static_cast<int>(controls->mode) & 128) != 0;
    std::copy_n(controls->controls.begin(), motors_.size(), motors_.begin());
    return;
  }
  watch_fence(packet);
  if (auto heartbeat = mav::decode<mv::Heartbeat>(packet)) {
    heartbeat->autopilot = mv::MavAutopilot::kArdupilotmega;
    heartbeat->type = mv::MavType::kQuadrotor;
    constexpr int kCustom = 1;
    constexpr int kArmed = 128;
    const bool armed = armed_ || is_armed_early();
    heartbeat->base_mode = static_cast<mv::MavModeFlag>(kCustom | 80 | (armed ? kArmed : 0));
    heartbeat->custom_mode = mode_;
    return ground_.send(*heartbeat);
  }
  if (auto version = mav::decode<mv::AutopilotVersion>(packet)) {
    // Its parameters are numbers, whatever their type.
    version->capabilities &= ~mv::MavProtocolCapability::kParamEncodeBytewise;
    return ground_.send(*version);
  }
  if (is_unasked(packet.message_id)) return;
  if (const auto status = mav::decode<mv::EstimatorStatus>(packet)) return say_ekf_report(*status);
  if (packet.message_id == mv::HomePosition::kId && is_early()) return;
  // PX4's own words and acknowledgements are not ArduPilot's.
  if (packet.message_id == mv::CommandAck::kId || packet.message_id == mv::HomePosition::kId) {
    if (const auto ack = mav::decode<mv::CommandAck>(packet)) {
      const bool armed = ack->command == mv::MavCmd::kComponentArmDisarm &&
                         ack->result == mv::MavResult::kAccepted;
      if (armed) armed_ = arming_;
      constexpr std::array kOwn{mv::MavCmd::kNavLand, mv::MavCmd::kDoSetMode,
                                mv::MavCmd::kNavReturnToLaunch, mv::MavCmd::kMissionStart};
      if (std::ranges::find(kOwn, ack->command) != kOwn.end()) return;
    }
  }
  ground_.forward(bytes);
}

/// Until it is asked, ArduPilot sends little more than HEARTBEAT, its texts and its answers.
void ScriptedArdupilot::note_wish(const mv::CommandLong& command) {
  auto id = static_cast<std::uint32_t>(command.param1);
  if (id == casd::kEkfStatusReport) id = mv::EstimatorStatus::kId;  // said in its place
  if (command.command == mv::MavCmd::kSetMessageInterval && command.param2 >= 0) {
    streams_.insert(id);
  } else if (command.command == mv::MavCmd::kRequestMessage) {
    wishes_.insert(id);
  }
}

bool ScriptedArdupilot::is_unasked(std::uint32_t message_id) {
  constexpr std::array kUnasked{
      mv::Statustext::kId,       mv::CommandAck::kId,     mv::ParamValue::kId,
      mv::AutopilotVersion::kId, mv::MissionCount::kId,   mv::MissionRequestInt::kId,
      mv::MissionAck::kId,       mv::MissionItemInt::kId, mv::MissionItemReached::kId,
      mv::Timesync::kId,         mv::Ping::kId,           mv::FileTransferProtocol::kId};
  if (std::ranges::find(kUnasked, message_id) != kUnasked.end()) return false;
  return !streams_.contains(message_id) && wishes_.erase(message_id) == 0;
}

bool ScriptedArdupilot::is_armed_early() const {
  return armed_early_at_ && time_ - *armed_early_at_ < std::chrono::seconds(10);
}

/// EKF_STATUS_REPORT of ArduPilot's dialect in the place of ESTIMATOR_STATUS.
void ScriptedArdupilot::say_ekf_report(const mv::EstimatorStatus& status) {
  constexpr std::uint8_t kCrcExtra = 71;
  std::array<std::uint8_t, 22> payload{};  // five floats, then the flags
  const auto flags = is_early() ? static_cast<unsigned>(mv::EstimatorStatusFlags::kAttitude)
                                : static_cast<unsigned>(status.flags);
  payload[20] = static_cast<std::uint8_t>(flags & 0xFFU);
  payload[21] = static_cast<std::uint8_t>(flags >> 8U);
  ground_.send_foreign(casd::kEkfStatusReport, kCrcExtra, payload);
}

void ScriptedArdupilot::on_ground_bytes(std::span<const std::uint8_t> bytes) {
  from_ground_.feed(bytes, [&](const mav::PacketView& packet) {
    const auto command = mav::decode<mv::CommandLong>(packet);
    if (command && command->target_system != 0 && command->target_system != options_.system) return;
    if (fence_.on_packet(packet, ground_)) return;
    if (command) note_wish(*command);
    if (command && on_command(*command, packet.source)) return;
    if (on_setpoint(packet)) return;
    if (const auto count = mav::decode<mv::MissionCount>(packet)) items_ = count->count;
    if (const auto item = mav::decode<mv::MissionItemInt>(packet); item && item->seq == 1) {
      begins_with_takeoff_ = item->command == mv::MavCmd::kNavTakeoff;
    }
    if (packet.message_id == mv::CommandInt::kId) follows_setpoints_ = false;  // DO_REPOSITION
    controller_.on_packet(packet, clock());
  });
}

void ScriptedArdupilot::acknowledge(const mv::CommandLong& command, mav::Source to,
                                    mv::MavResult result) {
  mv::CommandAck ack{.command = command.command,
                     .result = result,
                     .target_system = to.system,
                     .target_component = to.component};
  ground_.send(ack);
}

void ScriptedArdupilot::pass_on(mv::CommandLong command) {
  command.target_system = options_.system;
  command.target_component = 1;
  controller_.on_bytes(as_ground_(command), clock());
}

/// ArduCopter 4.5: AUTO needs a mission, and from the ground one that begins with a takeoff; item 0
/// is home.
bool ScriptedArdupilot::may_fly_mission() {
  if (items_ < 2) return false;
  const bool landed = newest_ && newest_->position[2] > -0.3;
  if (!armed_ || !landed || begins_with_takeoff_) return true;
  say("Auto: Missing Takeoff Cmd");
  return false;
}

void ScriptedArdupilot::fly_mission() {
  follows_setpoints_ = false;
  mv::CommandLong start{.command = mv::MavCmd::kMissionStart};
  start.param1 = 1;  // item 0 is not flown
  pass_on(start);
}

/// The inner controller holds its place: AUTO, and LOITER.
void ScriptedArdupilot::hold() {
  mode_ = kBrake;
  mv::CommandLong command{.command = mv::MavCmd::kDoSetMode, .param1 = 1, .param2 = 4, .param3 = 3};
  pass_on(command);
}

/// The inner controller's POSCTL follows the MANUAL_CONTROL that all pass on to it.
void ScriptedArdupilot::loiter() {
  pass_on(mv::CommandLong{.command = mv::MavCmd::kDoSetMode, .param1 = 1, .param2 = 3});
}

/// ArduCopter 4.5: a mode that it cannot enter fails. In AUTO it stays on the ground until the
/// throttle is raised; in the air it begins at once.
bool ScriptedArdupilot::set_mode(const mv::CommandLong& command, mav::Source from) {
  const auto mode = static_cast<std::uint32_t>(command.param2);
  const bool known = mode == kStabilize || (mode == kGuided && !is_early()) || mode == kLand ||
                     (mode == kAuto && may_fly_mission()) || mode == kLoiter || mode == kBrake;
  acknowledge(command, from, known ? mv::MavResult::kAccepted : mv::MavResult::kFailed);
  if (!known) return true;
  mode_ = mode;
  const bool in_air = newest_ && newest_->position[2] < -0.3;
  if (mode_ == kAuto && in_air) fly_mission();
  if (mode_ == kLoiter && in_air) loiter();
  if (mode_ == kBrake && in_air) hold();
  return true;
}

/// ArduCopter 4.5: without parameters only; AUTO, and the takeoff needs no throttle.
bool ScriptedArdupilot::start_mission(const mv::CommandLong& command, mav::Source from) {
  if (command.param1 != 0 || command.param2 != 0) {
    acknowledge(command, from, mv::MavResult::kDenied);
    return true;
  }
  const bool may = armed_ && may_fly_mission();
  acknowledge(command, from, may ? mv::MavResult::kAccepted : mv::MavResult::kFailed);
  if (!may) return true;
  mode_ = kAuto;
  fly_mission();
  return true;
}

/// ArduCopter 4.5 takes setpoints in GUIDED alone, and does not answer them. @return whether it was
/// one that it leaves
bool ScriptedArdupilot::on_setpoint(const mav::PacketView& packet) {
  if (packet.message_id != mv::SetPositionTargetLocalNed::kId) return false;
  if (mode_ != kGuided || !armed_) return true;
  controller_.on_packet(packet, clock());
  // Ours has ended OFFBOARD by then (COM_OF_LOSS_T); ArduCopter stops, and follows the next one.
  constexpr base::Duration kLost = std::chrono::milliseconds(900);
  if (time_ - std::exchange(newest_setpoint_, time_) > kLost) follows_setpoints_ = false;
  if (!std::exchange(follows_setpoints_, true)) {
    mv::CommandLong offboard{.command = mv::MavCmd::kDoSetMode, .param1 = 1};
    offboard.param2 = 6;  // our controller's OFFBOARD
    pass_on(offboard);
  }
  return true;
}

/// Home is where it was armed.
void ScriptedArdupilot::watch_fence(const mav::PacketView& packet) {
  const auto position = mav::decode<mv::LocalPositionNed>(packet);
  if (!position) return;
  const Eigen::Vector3d p_N(position->x, position->y, position->z);
  if (!armed_) return home_N_.reset();
  if (!home_N_) home_N_ = p_N;
  const ScriptedFence::Action action = fence_.update(p_N - *home_N_, clock());
  for (auto text = fence_.take_text(); !text.empty(); text = fence_.take_text()) {
    say(text, mv::MavSeverity::kNotice);
  }
  mv::CommandLong command;
  switch (action) {
    case ScriptedFence::Action::kNone:
      return;
    case ScriptedFence::Action::kHold:
      return hold();
    case ScriptedFence::Action::kReturn:
      mode_ = kRtl;
      command.command = mv::MavCmd::kNavReturnToLaunch;
      return pass_on(command);
    case ScriptedFence::Action::kLand:
      return land();
  }
}

void ScriptedArdupilot::land() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  mode_ = kLand;
  mv::CommandLong land{.command = mv::MavCmd::kNavLand};
  land.param4 = land.param5 = land.param6 = land.param7 = kNan;
  pass_on(land);
}

void ScriptedArdupilot::say(const std::string& text, mv::MavSeverity severity) {
  mv::Statustext message{.severity = severity};
  std::copy_n(text.begin(), std::min(text.size(), message.text.size()), message.text.begin());
  ground_.send(message);
}

/// The commands that ArduCopter takes its own way. @return false for those that pass as they are
bool ScriptedArdupilot::on_command(const mv::CommandLong& command, mav::Source from) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  if (command.command == mv::MavCmd::kComponentArmDisarm) {
    arming_ = command.param1 == 1;
    if (arming_ && is_early()) {
      armed_early_at_ = time_;
      acknowledge(command, from, mv::MavResult::kAccepted);
      return true;
    }
  }
  if (command.command == mv::MavCmd::kDoSetMode) return set_mode(command, from);
  if (command.command == mv::MavCmd::kMissionStart) return start_mission(command, from);
  if (command.command == mv::MavCmd::kNavReturnToLaunch) {
    acknowledge(command, from, mv::MavResult::kAccepted);
    mode_ = kRtl;
    pass_on(mv::CommandLong{.command = mv::MavCmd::kNavReturnToLaunch});
    return true;
  }
  if (command.command == mv::MavCmd::kNavLand) {
    acknowledge(command, from, mv::MavResult::kAccepted);
    land();
    return true;
  }
  if (command.command == mv::MavCmd::kNavTakeoff) {
    // Metres above home, in GUIDED, armed: anything else is refused.
    if (mode_ != kGuided || !armed_) {
      acknowledge(command, from, mv::MavResult::kFailed);
      return true;
    }
    mv::CommandLong takeoff = command;
    takeoff.param4 = takeoff.param5 = takeoff.param6 = kNan;
    takeoff.param7 = static_cast<float>(kHome.alt_m - newest_->position[2] + command.param7);
    pass_on(takeoff);
    return true;
  }
  return false;
}

}  // namespace cas::test

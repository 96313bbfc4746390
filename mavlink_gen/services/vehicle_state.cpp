// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/vehicle_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "mavlink/common/autopilot_version.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/px4_event.hpp"
#include "mavlink_gen/services/vehicle_heartbeat.hpp"

namespace cas::mav::services {
namespace {

using namespace mavlink::common;

constexpr std::size_t kStatusTexts = 10;
constexpr std::size_t kBeats = 10;
constexpr std::size_t kTextBytes = 1024;
/// Decodes into `slot` when the packet is of its kind.
template <class M>
void hear(std::optional<Heard<M>>& slot, const PacketView& packet, Time now) {
  if (const std::optional<M> message = decode<M>(packet)) slot = Heard<M>{*message, now};
}

constexpr Duration kFreshStatus = std::chrono::seconds(5);
constexpr auto kPrearmCheck = MavSysStatusSensor::kPrearmCheck;
/// PX4 1.13, the first to report its arming checks, as in AUTOPILOT_VERSION.flight_sw_version.
constexpr std::uint32_t kPx4TellsChecks = 1U << 24 | 13U << 16;
/// PX4 repeats failed checks at each request, ArduPilot every 30 s.
constexpr Duration kFreshText = std::chrono::seconds(45);

struct Sensor {
  MavSysStatusSensor bit;
  std::string_view name;
};

constexpr Sensor kNeeded[] = {
    {MavSysStatusSensor::k3dGyro, "gyroscope"},
    {MavSysStatusSensor::k3dAccel, "accelerometer"},
    {MavSysStatusSensor::k3dMag, "magnetometer"},
    {MavSysStatusSensor::kAbsolutePressure, "barometer"},
    {MavSysStatusSensor::kGps, "GPS"},
};

/// How PX4 (1.12, 1.16) and ArduPilot begin the reasons why they will not arm.
constexpr std::string_view kReasons[] = {"Preflight Fail", "PreArm", "Arm:", "Arming denied"};

bool is_reason(std::string_view text) {
  return std::any_of(std::begin(kReasons), std::end(kReasons),
                     [text](std::string_view word) { return text.starts_with(word); });
}

void add(std::vector<std::string>& all, std::string text) {
  if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(std::move(text));
}

bool has_fix(const VehicleState& vehicle, Time now) {
  const auto& gps = vehicle.gps_raw();
  return gps && vehicle.is_recent(gps->at, now) && gps->message.fix_type >= GpsFixType::k3dFix;
}

/// A sensor that is missing is not present and not healthy; of its receiver PX4 v1.16 says that it
/// is healthy and neither present nor enabled, also while its estimator does not use it.
void add_sensors(std::vector<std::string>& all, const VehicleState& vehicle, Time now) {
  const SysStatus& status = vehicle.sys_status()->message;
  const MavSysStatusSensor present = status.onboard_control_sensors_present;
  const MavSysStatusSensor enabled = status.onboard_control_sensors_enabled;
  const MavSysStatusSensor health = status.onboard_control_sensors_health;
  if ((present | enabled) == MavSysStatusSensor{}) return;  // PX4 v1.16 in its first second
  for (const Sensor& sensor : kNeeded) {
    const std::string name(sensor.name);
    const bool works = sensor.bit == MavSysStatusSensor::kGps && has_fix(vehicle, now);
    // PX4 v1.12 leaves "present" unset for sensors that it calls healthy.
    if (!has(present | (enabled & health), sensor.bit)) {
      if (!works) add(all, "no " + name);
    } else if (has(enabled, sensor.bit) && !has(health, sensor.bit)) {
      add(all, name + " not healthy");
    }
  }
}

struct Failure {
  HlFailureFlag bit;
  std::string_view name;
};

constexpr Failure kFailures[] = {
    {HlFailureFlag::kGps, "GPS"},
    {HlFailureFlag::kDifferentialPressure, "airspeed sensor"},
    {HlFailureFlag::kAbsolutePressure, "barometer"},
    {HlFailureFlag::k3dAccel, "accelerometer"},
    {HlFailureFlag::k3dGyro, "gyroscope"},
    {HlFailureFlag::k3dMag, "magnetometer"},
    {HlFailureFlag::kTerrain, "terrain system"},
    {HlFailureFlag::kBattery, "battery"},
    {HlFailureFlag::kRcReceiver, "radio control"},
    {HlFailureFlag::kOffboardLink, "offboard link"},
    {HlFailureFlag::kEngine, "engine"},
    {HlFailureFlag::kGeofence, "geofence"},
    {HlFailureFlag::kEstimator, "estimator"},
    {HlFailureFlag::kMission, "mission"},
};

void add_failures(std::vector<std::string>& all, const HighLatency2& message) {
  for (const Failure& failure : kFailures) {
    if (has(message.failure_flags, failure.bit)) add(all, std::string(failure.name) + " failure");
  }
}

/// PX4 v1.16 ends texts with a tab, v1.12 puts one between words.
std::string without_tabs(std::string text) {
  std::replace(text.begin(), text.end(), '\t', ' ');
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

std::optional<StatusText> StatusTextJoiner::add(const Statustext& chunk, Time now) {
  const std::string_view part = text(chunk.text);
  if (chunk.id == 0) return StatusText{chunk.severity, without_tabs(std::string(part)), now};
  if (chunk.chunk_seq == 0 || chunk.id != id_) text_.clear();
  if (chunk.chunk_seq != 0 && (chunk.id != id_ || chunk.chunk_seq != next_)) text_ += "...";
  id_ = chunk.id;
  next_ = static_cast<std::uint8_t>(chunk.chunk_seq + 1);
  text_ += part;
  const bool whole = part.size() < chunk.text.size() || text_.size() > kTextBytes;
  if (!whole) return std::nullopt;
  id_ = 0;
  return StatusText{chunk.severity, without_tabs(std::exchange(text_, {})), now};
}

void VehicleState::on_packet(const PacketView& packet, Time now) {
  if (now - heard_at_ > silent_after()) begin_anew(now);
  heard_at_ = now;
  messages_.on_packet(packet, now);
  switch (packet.message_id) {
    case Heartbeat::kId:
      if (const auto message = decode<Heartbeat>(packet)) on_heartbeat(*message, now);
      break;
    case HighLatency2::kId:
      if (const auto message = decode<HighLatency2>(packet)) on_high_latency(*message, now);
      break;
    case Attitude::kId:
      hear(attitude_, packet, now);
      if (attitude_) on_boot_time(attitude_->message.time_boot_ms, now);
      break;
    case LocalPositionNed::kId:
      hear(local_position_, packet, now);
      if (local_position_) on_boot_time(local_position_->message.time_boot_ms, now);
      break;
    case GlobalPositionInt::kId:
      hear(global_position_, packet, now);
      if (global_position_) on_boot_time(global_position_->message.time_boot_ms, now);
      break;
    case HomePosition::kId:
      hear(home_, packet, now);
      break;
    case ExtendedSysState::kId:
      hear(extended_, packet, now);
      break;
    case SysStatus::kId:
      hear(sys_status_, packet, now);
      if (sys_status_ && has(sys_status_->message.onboard_control_sensors_health, kPrearmCheck)) {
        passed_checks_at_ = now;
      }
      break;
    case BatteryStatus::kId:
      if (const auto message = decode<BatteryStatus>(packet); message && message->id == 0) {
        battery_ = {*message, now};
      }
      break;
    case GpsRawInt::kId:
      hear(gps_raw_, packet, now);
      break;
    case EstimatorStatus::kId:
      hear(estimator_, packet, now);
      break;
    case ServoOutputRaw::kId:
      if (const auto message = decode<ServoOutputRaw>(packet); message && message->port == 0) {
        servo_output_ = {*message, now};
      }
      break;
    case AutopilotVersion::kId:
      if (const auto message = decode<AutopilotVersion>(packet)) {
        capabilities_ = static_cast<std::uint64_t>(message->capabilities);
        flight_version_ = message->flight_sw_version;
      }
      break;
    case Statustext::kId:
      if (const auto message = decode<Statustext>(packet)) on_status_text(*message, now);
      break;
    case kEventMessage:
      if (const auto id = event_id(packet)) on_event(*id);
      break;
    default:
      break;
  }
}

void VehicleState::on_event(std::uint32_t id) {
  if (begins_check_list(id)) failed_checks_.clear();
  const std::string_view check = failed_check(id);
  const bool is_known = std::ranges::find(failed_checks_, check) != failed_checks_.end();
  if (!check.empty() && !is_known) failed_checks_.push_back(check);
}

void VehicleState::on_heartbeat(const Heartbeat& message, Time now) {
  heartbeat_ = {message, now};
  slow_ = false;
  beats_.push_back(now);
  if (beats_.size() > kBeats) beats_.pop_front();
  if (!hil()) without_hil_ = now;
  if (armed()) armed_at_ = now;
}

void VehicleState::on_high_latency(const HighLatency2& message, Time now) {
  high_latency_ = {message, now};
  if (!beats_.empty() && now - beats_.back() <= kVehicleTimeout) return;
  slow_ = true;
  heartbeat_ = {heartbeat_of(message, heartbeat_.message), now};
  without_hil_ = now;
  if (message.autopilot == MavAutopilot::kArdupilotmega && armed()) armed_at_ = now;
}

void VehicleState::on_boot_time(std::uint32_t time_boot_ms, Time now) {
  constexpr Duration kOutOfOrder = std::chrono::seconds(1);
  const Duration time = std::chrono::milliseconds(time_boot_ms);
  if (boot_time_ && time < *boot_time_ - kOutOfOrder) begin_anew(now);
  boot_time_ = time;
}

void VehicleState::begin_anew(Time now) {
  restarted_at_ = now;
  flight_version_ = 0;
  passed_checks_at_.reset();
  failed_checks_.clear();
}

bool VehicleState::has_beaten_long(Time now) const {
  return beats_.size() == kBeats && beats_.front() >= restarted_at_ &&
         now - beats_.back() <= kVehicleTimeout;
}

bool VehicleState::tells_checks() const {
  if (!sys_status_) return false;
  if (has(sys_status_->message.onboard_control_sensors_enabled, kPrearmCheck)) return true;
  return autopilot() == Autopilot::kPx4 &&
         (passed_checks_at_ || flight_version_ >= kPx4TellsChecks);
}

bool VehicleState::is_recent(Time said, Time now) const {
  if (said < restarted_at_) return false;
  return now - said <= kFreshStatus || beats_.size() < kBeats || said >= beats_.front();
}

void VehicleState::on_status_text(const Statustext& chunk, Time now) {
  std::optional<StatusText> whole = joiner_.add(chunk, now);
  if (!whole) return;
  status_texts_.push_back(std::move(*whole));
  if (status_texts_.size() > kStatusTexts) status_texts_.pop_front();
  ++status_text_count_;
}

Autopilot VehicleState::autopilot() const { return autopilot_family(heartbeat_.message.autopilot); }

bool VehicleState::armed() const {
  return has(heartbeat_.message.base_mode, MavModeFlag::kSafetyArmed);
}

bool VehicleState::hil() const {
  return has(heartbeat_.message.base_mode, MavModeFlag::kHilEnabled);
}

bool VehicleState::denied_hil(Time now) const {
  return without_hil_ && now - *without_hil_ <= kVehicleTimeout;
}

std::string VehicleState::mode() const {
  return mode_name(mode_set(), heartbeat_.message.base_mode, heartbeat_.message.custom_mode);
}

bool VehicleState::waits_for_sticks() const {
  if (autopilot() != Autopilot::kPx4) return false;
  const std::string now = mode();
  return now == "MANUAL" || now == "ALTCTL" || now == "POSCTL" || now == "STABILIZED" ||
         now == "ACRO";
}

MavLandedState VehicleState::landed() const {
  return extended_ ? extended_->message.landed_state : MavLandedState::kUndefined;
}

std::optional<Time> VehicleState::landed_at() const {
  return extended_ ? std::optional(extended_->at) : std::nullopt;
}

std::string_view VehicleState::landed_word() const {
  switch (landed()) {
    case MavLandedState::kOnGround:
      return "on_ground";
    case MavLandedState::kInAir:
      return "in_air";
    case MavLandedState::kTakeoff:
      return "taking_off";
    case MavLandedState::kLanding:
      return "landing";
    default:
      return "undefined";
  }
}

std::string_view VehicleState::vtol_word() const {
  if (!extended_) return {};
  switch (extended_->message.vtol_state) {
    case MavVtolState::kMc:
      return "multicopter";
    case MavVtolState::kTransitionToFw:
      return "to_plane";
    case MavVtolState::kFw:
      return "plane";
    case MavVtolState::kTransitionToMc:
      return "to_multicopter";
    default:
      return {};
  }
}

std::optional<Heard<double>> VehicleState::altitude() const {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const double z_m = local_position_ ? double{local_position_->message.z} : kUnknown;
  const double home_z_m = home_ ? double{home_->message.z} : kUnknown;
  if (std::isfinite(home_z_m - z_m)) return Heard<double>{home_z_m - z_m, local_position_->at};
  if (global_position_) {
    return Heard<double>{global_position_->message.relative_alt * 1e-3, global_position_->at};
  }
  if (std::isfinite(z_m)) return Heard<double>{-z_m, local_position_->at};
  return std::nullopt;
}

ParamEncoding VehicleState::param_encoding() const {
  constexpr auto kBytewise =
      static_cast<std::uint64_t>(MavProtocolCapability::kParamEncodeBytewise);
  if (capabilities_ && (*capabilities_ & kBytewise) != 0) return ParamEncoding::kBytewise;
  return autopilot() == Autopilot::kArduPilot ? ParamEncoding::kCast : ParamEncoding::kBytewise;
}

std::string VehicleState::firmware_version() const {
  if (flight_version_ == 0) return {};
  const auto byte = [this](unsigned shift) {
    return std::to_string(flight_version_ >> shift & 0xFFU);
  };
  return byte(24) + "." + byte(16) + "." + byte(8);
}

ArmingChecks arming_checks(const VehicleState& vehicle, Time now) {
  const auto& status = vehicle.sys_status();
  const bool fresh =
      status && status->at >= vehicle.restarted_at() && now - status->at <= kFreshStatus;
  if (!fresh || !vehicle.tells_checks()) return ArmingChecks::kUnknown;
  return has(status->message.onboard_control_sensors_health, kPrearmCheck) ? ArmingChecks::kPass
                                                                           : ArmingChecks::kFail;
}

namespace {

/// Five floats, then the flags; zeros at the end are cut off.
EstimatorStatusFlags ekf_flags(const MessageMemory::Kept& report) {
  constexpr std::size_t kFlags = 20;
  const auto byte = [&](std::size_t at) {
    return at < report.payload.size() ? static_cast<unsigned>(report.payload[at]) : 0U;
  };
  // The bits are those of ESTIMATOR_STATUS.
  return static_cast<EstimatorStatusFlags>(byte(kFlags) | byte(kFlags + 1) << 8U);
}

/// The estimator's flags in the newest report of either autopilot.
std::optional<EstimatorStatusFlags> estimator_flags(const VehicleState& vehicle, Time now) {
  const auto& status = vehicle.estimator_status();
  if (status && vehicle.is_recent(status->at, now)) return status->message.flags;
  const MessageMemory::Kept* report = vehicle.messages().find(kEkfStatusReport);
  if (vehicle.autopilot() != Autopilot::kArduPilot || report == nullptr ||
      !vehicle.is_recent(report->at, now)) {
    return std::nullopt;
  }
  return ekf_flags(*report);
}

/// PX4 sets CONST_POS_MODE also while it stands still (v1.16.0 and later), so the position bits
/// alone decide; in ArduPilot's report it means that there is no position.
std::string estimator_lack(EstimatorStatusFlags flags, Autopilot autopilot) {
  using E = EstimatorStatusFlags;
  if (!has(flags, E::kAttitude)) return "the estimator has no attitude yet";
  if (!has(flags, E::kVelocityHoriz | E::kVelocityVert)) return "the estimator has no velocity yet";
  const bool constant = autopilot == Autopilot::kArduPilot && has(flags, E::kConstPosMode);
  if (!has(flags, E::kPosHorizAbs) || constant) {
    return "the estimator has no horizontal position yet";
  }
  return has(flags, E::kPosVertAbs) ? "" : "the estimator has no height yet";
}

/// For a vehicle whose estimator says nothing.
std::string gps_lack(const VehicleState& vehicle, Time now) {
  const auto& gps = vehicle.gps_raw();
  if (!gps || !vehicle.is_recent(gps->at, now)) return "it tells nothing of its estimator and GPS";
  return gps->message.fix_type < GpsFixType::k3dFix ? "the GPS has no fix yet" : "";
}

std::string first_lack(const VehicleState& vehicle, Time now) {
  std::string lack;
  if (const auto flags = estimator_flags(vehicle, now)) {
    lack = estimator_lack(*flags, vehicle.autopilot());
  } else if (!vehicle.is_high_latency() && !vehicle.has_beaten_long(now)) {
    lack = "its estimator has not reported yet";
  } else {
    lack = gps_lack(vehicle, now);
  }
  if (!lack.empty()) return lack;
  const auto& home = vehicle.told_home();
  if (!home || home->at < vehicle.restarted_at()) return "it has not told its home position yet";
  // In a mode for sticks the checks fail without a transmitter: casd arms such a PX4 in HOLD.
  const bool failed =
      arming_checks(vehicle, now) == ArmingChecks::kFail && !vehicle.waits_for_sticks();
  return failed ? "its arming checks fail" : "";
}

}  // namespace

std::string position_lack(const VehicleState& vehicle, Time now) {
  if (vehicle.autopilot() == Autopilot::kOther) return {};
  std::string lack = first_lack(vehicle, now);
  if (lack.empty()) return lack;
  std::vector<std::string> reasons;
  const auto& status = vehicle.sys_status();
  if (status && vehicle.is_recent(status->at, now)) add_sensors(reasons, vehicle, now);
  for (const std::string_view check : vehicle.failed_checks()) add(reasons, std::string(check));
  for (const std::string& reason : reasons) lack += "; " + reason;
  return lack;
}

std::vector<std::string> complaints(const VehicleState& vehicle, Time now,
                                    std::uint64_t texts_before) {
  std::vector<std::string> all;
  const auto& status = vehicle.sys_status();
  if (status && now - status->at < kFreshStatus) add_sensors(all, vehicle, now);
  if (vehicle.is_high_latency()) add_failures(all, vehicle.high_latency()->message);
  if (vehicle.armed()) return all;
  for (const std::string_view check : vehicle.failed_checks()) add(all, std::string(check));
  std::uint64_t number = vehicle.status_text_count() - vehicle.status_texts().size();
  for (const StatusText& text : vehicle.status_texts()) {
    if (number++ < texts_before) continue;
    const bool over = vehicle.armed_at() && text.at <= *vehicle.armed_at();
    if (!over && now - text.at < kFreshText && is_reason(text.text)) add(all, text.text);
  }
  return all;
}

}  // namespace cas::mav::services

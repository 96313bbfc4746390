// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mavlink/common/attitude.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/global_position_int.hpp"
#include "mavlink/common/gps_raw_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/high_latency2.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/message_memory.hpp"
#include "mavlink_gen/services/param_exchange.hpp"
#include "mavlink_gen/services/time.hpp"
#include "mavlink_gen/services/vehicle_modes.hpp"

namespace cas::mav::services {

/// The newest message of a kind and when it came.
template <class M>
struct Heard {
  M message{};
  Time at{};
};

/// One whole status text, chunks joined.
struct StatusText {
  mavlink::common::MavSeverity severity{};
  std::string text;
  Time at{};
};

/// Joins the chunks of long status texts (STATUSTEXT.id, chunk_seq). Holds one text at a time.
class StatusTextJoiner {
 public:
  /// @return the whole text when this chunk ends it
  std::optional<StatusText> add(const mavlink::common::Statustext& chunk, Time now);

 private:
  std::uint16_t id_ = 0;
  std::uint8_t next_ = 0;
  std::string text_;
};

/// A vehicle is silent when no HEARTBEAT has come for this long.
inline constexpr Duration kVehicleTimeout = std::chrono::seconds(3);

/// The same for a vehicle on a high latency link: PX4 (1.16) sends HIGH_LATENCY2 over Iridium at
/// 0.015 Hz, ArduPilot every 5 s. Three of the longer periods.
inline constexpr Duration kHighLatencyTimeout = std::chrono::seconds(200);

/// EKF_STATUS_REPORT, a message of ArduPilot's dialect.
inline constexpr std::uint32_t kEkfStatusReport = 193;

/// State of one vehicle, from its own messages. Pure: packets and times come in as arguments. The
/// caller leaves out packets of other senders; is_vehicle() tells whether a HEARTBEAT is a
/// vehicle's.
///
/// On a high latency link HIGH_LATENCY2 takes the place of the HEARTBEAT once none of those has
/// come for kVehicleTimeout. It never says that the vehicle is in HIL, and PX4's does not say
/// whether it is armed: the last known state stays.
///
///   VehicleState vehicle(heartbeat_source, now);  // casd's station: at the first HEARTBEAT
///   vehicle.on_packet(packet, now);               // each packet of its autopilot
///   if (vehicle.armed() && vehicle.heartbeat_age(now) < vehicle.silent_after()) ...
class VehicleState {
 public:
  VehicleState(Source source, Time now) : source_(source), heard_at_(now) {}

  /// Takes in one packet of this vehicle's autopilot.
  void on_packet(const PacketView& packet, Time now);

  Source source() const { return source_; }
  Autopilot autopilot() const;
  mavlink::common::MavType type() const { return heartbeat_.message.type; }
  ModeSet mode_set() const { return services::mode_set(autopilot(), type()); }
  bool armed() const;
  /// Whether its newest HEARTBEAT says that it flies a simulation.
  bool hil() const;
  /// Whether a HEARTBEAT without the HIL flag came lately: of two autopilots behind one router or
  /// on one group of links, each is heard here.
  bool denied_hil(Time now) const;
  std::string mode() const;
  /// Whether it is a PX4 in a mode that needs a pilot's sticks.
  bool waits_for_sticks() const;
  const Heard<mavlink::common::Heartbeat>& heartbeat() const { return heartbeat_; }
  /// Age of the newest HEARTBEAT, or of the HIGH_LATENCY2 in its place.
  Duration heartbeat_age(Time now) const { return now - heartbeat_.at; }
  /// How old that may be before the vehicle counts as silent.
  Duration silent_after() const { return slow_ ? kHighLatencyTimeout : kVehicleTimeout; }
  /// Whether HIGH_LATENCY2 is all that tells of it.
  bool is_high_latency() const { return slow_; }
  const std::optional<Heard<mavlink::common::HighLatency2>>& high_latency() const {
    return high_latency_;
  }
  /// The vehicle's own clock, by the newest packet that carries it: time since it was started.
  std::optional<Duration> boot_time() const { return boot_time_; }
  /// Time of its last detected restart, by its clock or after silence: earlier data may belong to
  /// an earlier start.
  Time restarted_at() const { return restarted_at_; }
  /// Whether data received at `said` is still valid: since this start, and within the last 5 s or
  /// the last 10 HEARTBEATs, which follow the vehicle's own clock.
  bool is_recent(Time said, Time now) const;
  /// Whether its last ten HEARTBEATs came since its start: time enough to report what it reports.
  bool has_beaten_long(Time now) const;
  /// Whether its SYS_STATUS tells of its arming checks (MAV_SYS_STATUS_PREARM_CHECK): `enabled` has
  /// the bit. PX4 1.13 to 1.18 sets it in `health` alone, once the checks pass; such a PX4 is known
  /// by its version, or has passed them since its start.
  bool tells_checks() const;
  /// When a HEARTBEAT last said that it is armed.
  std::optional<Time> armed_at() const { return armed_at_; }

  mavlink::common::MavLandedState landed() const;
  std::string_view landed_word() const;
  /// How a VTOL flies: "multicopter", "to_plane", "plane", "to_multicopter"; empty: it is none, or
  /// has not said.
  std::string_view vtol_word() const;
  /// When it last said whether it has landed.
  std::optional<Time> landed_at() const;
  const std::optional<Heard<mavlink::common::Attitude>>& attitude() const { return attitude_; }
  const std::optional<Heard<mavlink::common::LocalPositionNed>>& local_position() const {
    return local_position_;
  }
  const std::optional<Heard<mavlink::common::GlobalPositionInt>>& global_position() const {
    return global_position_;
  }
  const std::optional<Heard<mavlink::common::SysStatus>>& sys_status() const { return sys_status_; }
  /// BATTERY_STATUS of the first battery.
  const std::optional<Heard<mavlink::common::BatteryStatus>>& battery_status() const {
    return battery_;
  }
  const std::optional<Heard<mavlink::common::GpsRawInt>>& gps_raw() const { return gps_raw_; }
  const std::optional<Heard<mavlink::common::EstimatorStatus>>& estimator_status() const {
    return estimator_;
  }
  /// SERVO_OUTPUT_RAW of the main outputs.
  const std::optional<Heard<mavlink::common::ServoOutputRaw>>& servo_output() const {
    return servo_output_;
  }
  /// The newest packet of each message that was taken in.
  const MessageMemory& messages() const { return messages_; }
  const std::optional<Heard<mavlink::common::HomePosition>>& told_home() const { return home_; }
  /// Height above home in m from the vehicle's newest message, with its time.
  std::optional<Heard<double>> altitude() const;
  ParamEncoding param_encoding() const;
  /// "1.12.0", by AUTOPILOT_VERSION; empty until the vehicle reports it.
  std::string firmware_version() const;

  /// Failed checks in the newest list of them that a PX4 has sent as EVENTs, in words.
  const std::vector<std::string_view>& failed_checks() const { return failed_checks_; }
  /// The newest whole status texts, oldest first, at most ten.
  const std::deque<StatusText>& status_texts() const { return status_texts_; }
  /// Counts every whole status text: a change of the value shows that one came.
  std::uint64_t status_text_count() const { return status_text_count_; }

 private:
  void on_heartbeat(const mavlink::common::Heartbeat& message, Time now);
  void on_high_latency(const mavlink::common::HighLatency2& message, Time now);
  void on_boot_time(std::uint32_t time_boot_ms, Time now);
  void begin_anew(Time now);
  void on_event(std::uint32_t id);
  void on_status_text(const mavlink::common::Statustext& chunk, Time now);

  Source source_;
  Time heard_at_;
  std::optional<Time> without_hil_;  ///< newest HEARTBEAT without the HIL flag
  Heard<mavlink::common::Heartbeat> heartbeat_{};
  bool slow_ = false;       ///< `heartbeat_` comes from a HIGH_LATENCY2
  std::deque<Time> beats_;  ///< when the newest HEARTBEATs came
  std::optional<Time> armed_at_;
  std::optional<Time> passed_checks_at_;  ///< by SYS_STATUS, since its start
  std::optional<Duration> boot_time_;
  Time restarted_at_{};
  std::optional<Heard<mavlink::common::ExtendedSysState>> extended_;
  std::optional<Heard<mavlink::common::HighLatency2>> high_latency_;
  std::optional<Heard<mavlink::common::Attitude>> attitude_;
  std::optional<Heard<mavlink::common::LocalPositionNed>> local_position_;
  std::optional<Heard<mavlink::common::GlobalPositionInt>> global_position_;
  std::optional<Heard<mavlink::common::HomePosition>> home_;
  std::optional<Heard<mavlink::common::SysStatus>> sys_status_;
  std::optional<Heard<mavlink::common::BatteryStatus>> battery_;
  std::optional<Heard<mavlink::common::GpsRawInt>> gps_raw_;
  std::optional<Heard<mavlink::common::EstimatorStatus>> estimator_;
  std::optional<Heard<mavlink::common::ServoOutputRaw>> servo_output_;
  MessageMemory messages_;
  std::optional<std::uint64_t> capabilities_;
  std::uint32_t flight_version_ = 0;  ///< major, minor, patch, kind: a byte each
  std::vector<std::string_view> failed_checks_;
  StatusTextJoiner joiner_;
  std::deque<StatusText> status_texts_;
  std::uint64_t status_text_count_ = 0;
};

/// Result of a vehicle's own arming checks (SYS_STATUS, MAV_SYS_STATUS_PREARM_CHECK).
enum class ArmingChecks { kUnknown, kPass, kFail };
/// kUnknown while no fresh SYS_STATUS tells of them.
ArmingChecks arming_checks(const VehicleState& vehicle, Time now);

/// Missing preconditions of a takeoff with position control, in words; empty: nothing, or its kind
/// of autopilot does not report it. Before that stock firmware accepts arming, refuses to take off
/// and disarms itself after 8 to 10 s (PX4 v1.12.0, ArduCopter 4.5.6), or refuses (PX4 v1.16).
///
/// The estimator's own report counts: ESTIMATOR_STATUS of PX4, EKF_STATUS_REPORT of ArduPilot;
/// where none has come after ten HEARTBEATs, a fix of the GPS. HOME_POSITION is required, too, and
/// that the vehicle's arming checks do not fail. Behind what is missing stand the sensors that
/// SYS_STATUS lacks and the failed checks that PX4 tells as EVENT. Old reports do not count.
std::string position_lack(const VehicleState& vehicle, Time now);

/// Reasons not to fly, in words, as the vehicle reports them: required sensors that are missing or
/// unhealthy (SYS_STATUS), failed parts (HIGH_LATENCY2), and recent reasons of its own checks
/// ("Preflight Fail: ...", "PreArm: ..."). Reasons from before its last arming do not count. Empty:
/// none.
/// @param texts_before  number of status texts before a request: those do not count
std::vector<std::string> complaints(const VehicleState& vehicle, Time now,
                                    std::uint64_t texts_before = 0);

}  // namespace cas::mav::services

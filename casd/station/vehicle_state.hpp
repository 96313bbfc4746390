// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/station/message_memory.hpp"
#include "casd/station/param_exchange.hpp"
#include "casd/station/vehicle_modes.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/battery_status.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/global_position_int.hpp"
#include "mavlink/common/gps_raw_int.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/servo_output_raw.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// The newest message of a kind and when it came.
template <class M>
struct Heard {
  M message{};
  base::RunTime at{};
};

/// One whole status text, chunks joined.
struct StatusText {
  mavlink::common::MavSeverity severity{};
  std::string text;
  base::RunTime at{};
};

/// Joins the chunks of long status texts (STATUSTEXT.id, chunk_seq). Holds one text at a time.
class StatusTextJoiner {
 public:
  /// @return the whole text when this chunk ends it
  std::optional<StatusText> add(const mavlink::common::Statustext& chunk, base::RunTime now);

 private:
  std::uint16_t id_ = 0;
  std::uint8_t next_ = 0;
  std::string text_;
};

/// A place on the wire's terms.
struct HomeAmsl {
  double lat_deg = 0;
  double lon_deg = 0;
  double alt_m = 0;                  ///< above mean sea level
  double x_m = 0, y_m = 0, z_m = 0;  ///< of home in the vehicle's local frame N
};

/// A vehicle is silent when no HEARTBEAT has come for this long.
inline constexpr base::Duration kVehicleTimeout = std::chrono::seconds(3);

/// EKF_STATUS_REPORT, a message of ArduPilot's dialect.
inline constexpr std::uint32_t kEkfStatusReport = 193;

/// Another autopilot that uses a vehicle's system id.
struct Rival {
  mav::Source source;
  Origin from;
  base::RunTime at{};  ///< of its newest HEARTBEAT
};

/// What one vehicle has said about itself. Pure: packets and times come in as arguments.
///
/// A vehicle is an autopilot at one place: a link, and on a server link one peer of it. The links
/// of a group are one place, with at most one peer on each link.
class VehicleState {
 public:
  VehicleState(mav::Source source, const Origin& origin, base::RunTime now)
      : source_(source), group_(origin.group), ways_{{origin.path, now}} {}

  /// Whether a packet from there comes from this vehicle's place.
  bool is_at(const Origin& from, base::RunTime now) const;
  /// Takes in one packet of this vehicle's autopilot, from its place.
  void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  /// Forgets the ways over these links. @return whether any way is left
  bool forget(LinkMask links);

  mav::Source source() const { return source_; }
  /// The link that it is heard on: with redundant links the first, while that one speaks.
  LinkId link() const { return ways_.front().path.link; }
  Origin origin() const { return {ways_.front().path, group_}; }
  /// All ways to it.
  std::vector<Path> paths() const;

  /// Another autopilot uses this vehicle's system id.
  void on_rival(const Rival& rival) { rival_ = rival; }
  /// The rival that spoke last, unless it is silent by now.
  std::optional<Rival> rival(base::RunTime now) const;

  Autopilot autopilot() const;
  mavlink::common::MavType type() const { return heartbeat_.message.type; }
  bool armed() const;
  /// Whether its newest HEARTBEAT says that it flies a simulation.
  bool hil() const;
  /// Whether a HEARTBEAT without the HIL flag came lately: of two autopilots behind one router or
  /// on one group of links, each is heard here.
  bool denied_hil(base::RunTime now) const;
  std::string mode() const;
  /// Whether it is a PX4 in a mode that flies by somebody's sticks.
  bool waits_for_sticks() const;
  const Heard<mavlink::common::Heartbeat>& heartbeat() const { return heartbeat_; }
  base::Duration heartbeat_age(base::RunTime now) const { return now - heartbeat_.at; }
  /// The vehicle's own clock, by the newest packet that carries it: time since it was started.
  std::optional<base::Duration> boot_time() const { return boot_time_; }
  /// When it was last seen to begin anew, by its clock or after silence: what it told before may be
  /// of another start.
  base::RunTime restarted_at() const { return restarted_at_; }
  /// Whether what it said then still tells of it: since this start, and within the last 5 s or the
  /// last 10 of its HEARTBEATs, which go by its own clock.
  bool is_recent(base::RunTime said, base::RunTime now) const;
  /// When a HEARTBEAT last said that it is armed.
  std::optional<base::RunTime> armed_at() const { return armed_at_; }

  mavlink::common::MavLandedState landed() const;
  std::string_view landed_word() const;
  /// When it last said whether it has landed.
  std::optional<base::RunTime> landed_at() const;
  const std::optional<Heard<mavlink::common::Attitude>>& attitude() const { return attitude_; }
  const std::optional<Heard<mavlink::common::LocalPositionNed>>& local_position() const {
    return local_position_;
  }
  const std::optional<Heard<mavlink::common::GlobalPositionInt>>& global_position() const {
    return global_position_;
  }
  const std::optional<Heard<mavlink::common::SysStatus>>& sys_status() const { return sys_status_; }
  /// Of the first battery.
  const std::optional<Heard<mavlink::common::BatteryStatus>>& battery_status() const {
    return battery_;
  }
  const std::optional<Heard<mavlink::common::GpsRawInt>>& gps_raw() const { return gps_raw_; }
  const std::optional<Heard<mavlink::common::EstimatorStatus>>& estimator_status() const {
    return estimator_;
  }
  /// Of the main outputs.
  const std::optional<Heard<mavlink::common::ServoOutputRaw>>& servo_output() const {
    return servo_output_;
  }
  /// The newest packet of each message that casd's station hears: all but the HIL messages.
  const MessageMemory& messages() const { return messages_; }
  /// By HOME_POSITION alone.
  const std::optional<Heard<mavlink::common::HomePosition>>& told_home() const { return home_; }
  /// HOME_POSITION, or what GLOBAL_POSITION_INT and LOCAL_POSITION_NED together imply.
  std::optional<HomeAmsl> home() const;
  /// Height above home in m, from the newest of what the vehicle tells, and when it told it.
  std::optional<Heard<double>> altitude() const;
  ParamEncoding param_encoding() const;
  /// "1.12.0", by AUTOPILOT_VERSION; empty while the vehicle has not told it.
  std::string firmware_version() const;

  /// The newest whole status texts, oldest first, at most ten.
  const std::deque<StatusText>& status_texts() const { return status_texts_; }
  /// Counts every whole status text: who compares two values knows whether one came.
  std::uint64_t status_text_count() const { return status_text_count_; }

 private:
  struct Way {
    Path path;
    base::RunTime at{};  ///< of the newest packet
  };

  void heard_over(const Origin& from, base::RunTime now);
  void on_heartbeat(const mavlink::common::Heartbeat& message, base::RunTime now);
  void on_boot_time(std::uint32_t time_boot_ms, base::RunTime now);
  void begin_anew(base::RunTime now);
  void on_status_text(const mavlink::common::Statustext& chunk, base::RunTime now);

  mav::Source source_;
  std::int8_t group_;
  std::vector<Way> ways_;  ///< the one in use first; never empty while the vehicle is known
  std::optional<Rival> rival_;
  std::optional<base::RunTime> without_hil_;  ///< newest HEARTBEAT without the HIL flag
  Heard<mavlink::common::Heartbeat> heartbeat_{};
  std::deque<base::RunTime> beats_;  ///< when the newest HEARTBEATs came
  std::optional<base::RunTime> armed_at_;
  std::optional<base::Duration> boot_time_;
  base::RunTime restarted_at_{};
  std::optional<Heard<mavlink::common::ExtendedSysState>> extended_;
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
  StatusTextJoiner joiner_;
  std::deque<StatusText> status_texts_;
  std::uint64_t status_text_count_ = 0;
};

/// What a vehicle's own arming checks say (SYS_STATUS, MAV_SYS_STATUS_PREARM_CHECK).
enum class ArmingChecks { kUnknown, kPass, kFail };
/// kUnknown while no fresh SYS_STATUS tells of them.
ArmingChecks arming_checks(const VehicleState& vehicle, base::RunTime now);

/// What a vehicle would need before it can take off by its position, in words; empty: nothing, or
/// its autopilot is of a kind that does not tell. Stock firmware accepts arming before that,
/// refuses to take off and disarms itself after 8 to 10 s (PX4 v1.12.0, ArduCopter 4.5.6).
///
/// The estimator's own word counts: ESTIMATOR_STATUS of PX4, EKF_STATUS_REPORT of ArduPilot; where
/// neither comes, a fix of the GPS. Beside it HOME_POSITION must have come. What is not recent does
/// not count.
std::string position_lack(const VehicleState& vehicle, base::RunTime now);

/// Reasons not to fly, in words, as the vehicle reports them: required sensors that are missing or
/// unhealthy (SYS_STATUS), and recent reasons of its own checks ("Preflight Fail: ...",
/// "PreArm: ..."). What it said before it was last armed is over. Empty: none.
/// @param texts_before  how many status texts had come before a request: those do not count
std::vector<std::string> complaints(const VehicleState& vehicle, base::RunTime now,
                                    std::uint64_t texts_before = 0);

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/packet/message_rate.hpp"
#include "casd/packet/own_station.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/own_heartbeat.hpp"
#include "casd/station/services.hpp"
#include "casd/station/takeoff.hpp"
#include "casd/station/vehicle_state.hpp"
#include "casd/station/vehicle_table.hpp"
#include "mavlink/common/logging_ack.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/remote_log.hpp"

namespace cas::casd {

/// Hands one whole packet to the router as if it came from casd's own station: to the vehicle at
/// the end of these paths alone, or, without paths, to every link.
/// Only to be called on casd's main thread; never blocks.
using SendPacket =
    std::function<void(std::span<const std::uint8_t> packet, std::span<const Path> to)>;

/// The station at casd's own address (kOwnStation by default): hears every packet that is addressed
/// to it or broadcast, apart from HIL_* sensor and actuator streams. All calls come on casd's main
/// io thread; packets cross over from the link threads through a bounded queue.
class Station {
 public:
  virtual ~Station() = default;
  /// `packet` lives during the call only.
  virtual void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now) = 0;
  /// Now and then (VehicleCommander::next_tick): retries, timeouts, heartbeats.
  virtual void tick(base::RunTime now) = 0;
};

/// Period of the station's work on the virtual clock, and the longest time between two ticks while
/// logs of autopilots are taken.
inline constexpr base::Duration kStationTick = std::chrono::milliseconds(50);
/// The longest time between two ticks of a station that waits for nothing: each wakes a thread.
inline constexpr base::Duration kRestTick = std::chrono::milliseconds(250);

/// Settings of a VehicleCommander: its own messages, its consents, its timing.
struct CommanderOptions {
  mav::Source self = kOwnStation;
  double heartbeat_hz = 1;     ///< own HEARTBEAT as a ground station; 0 is silent. A vehicle that
                               ///< runs faster than real time gets it by its own clock
  bool allow_not_hil = false;  ///< consent to spin or move vehicles that are not in HIL
  /// Ask a new vehicle, and one that has restarted, for AUTOPILOT_VERSION and HOME_POSITION, and an
  /// ArduPilot for its telemetry.
  bool ask_on_sight = true;
  CommandTiming command_timing{};
  ParamTiming param_timing{};
  std::function<std::string(LinkId)> link_name{};  ///< for sentences; empty: their numbers
  /// Message rates requested from the vehicles of a link, on the same occasions; empty: none.
  std::function<std::vector<MessageRate>(LinkId)> request_rates{};
};

/// casd as a ground station: knows the vehicles and commands them, by the MAVLink command and
/// parameter protocols. Pure: packets, time and requests come in as arguments, packets go out
/// through a callback; everything on one thread.
///
/// Each request ends with exactly one call of its `done`, which may start further requests.
class VehicleCommander final : public Station {
 public:
  /// Called with each whole status text.
  using OnText = std::function<void(const VehicleState&, const StatusText&)>;

  VehicleCommander(CommanderOptions options, SendPacket send);

  void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now) override;
  /// The same for a link without peers and group.
  void on_packet(LinkId link, const mav::PacketView& packet, base::RunTime now) {
    on_packet(Origin{{link}}, packet, now);
  }
  void tick(base::RunTime now) override;
  /// When to call tick() next: at the first deadline of a request, or when the own HEARTBEAT is
  /// due, but no later than in kRestTick. A new packet or request may make it sooner.
  base::RunTime next_tick(base::RunTime now) const;
  /// For a simulated `now`, which may stand still: call it regularly with this machine's clock, so
  /// that an accepted command without effect still times out.
  void wall_tick(base::RunTime wall);
  void on_text(OnText callback) { on_text_ = std::move(callback); }
  /// Takes MAV_CMD_INJECT_FAILURE that command() is to send: no vehicle gets it.
  void on_failure(std::function<void(std::uint8_t system, const VehicleCommand&, Done)> callback) {
    on_failure_ = std::move(callback);
  }
  /// Called with a sentence when a second autopilot with a vehicle's id appears or falls silent,
  /// and when a vehicle does not send messages that its link requests.
  void on_notice(std::function<void(const std::string&)> callback) {
    table_.on_notice(std::move(callback));
  }
  /// Forgets vehicles that were heard only on these links, which are gone for good.
  void forget(const LinkMask& links) { table_.forget(links); }

  /// Changes these options from now on. Where the consent is withdrawn, a command under way that
  /// needs it is not sent again either.
  void set_commanding(double heartbeat_hz, bool allow_not_hil, bool ask_on_sight);

  const VehicleState* find(std::uint8_t system) const;
  /// Commanders of the vehicles of this id, as far as casd knows.
  const Hands& hands(std::uint8_t system) const;
  std::vector<const VehicleState*> vehicles() const;
  /// Whether a vehicle was armed when it was last heard, within the last minute.
  bool any_armed(base::RunTime now) const;
  /// The vehicle a request means: the one named, or the only one there is.
  /// @return its system id, or why there is none
  std::variant<std::uint8_t, Outcome> resolve(std::optional<std::uint8_t> asked) const {
    return table_.resolve(asked);
  }

  /// Why a vehicle is not known to be in HIL, in a sentence; nullopt: its HEARTBEATs, and only its,
  /// say so.
  std::optional<std::string> hil_doubt(std::uint8_t system, base::RunTime now) const;

  struct ArmOptions {
    bool force = false;    ///< skip the vehicle's own checks
    bool not_hil = false;  ///< arm although the vehicle does not say that it is in HIL
  };
  /// A refusal names the missing sensors and the status texts that followed the request. A PX4 that
  /// refuses in a stick mode is put into HOLD and asked again, unless a newer request to arm or
  /// disarm has come.
  /// A later disarm ends the request: no repetition of it follows the disarm.
  /// Refused with kInterlock for a vehicle without the HIL flag, unless request and configuration
  /// both consent, and while a second autopilot uses its system id. Each repetition asks again.
  void arm(std::uint8_t system, ArmOptions options, base::RunTime now, Done done);
  void disarm(std::uint8_t system, bool force, base::RunTime now, Done done);
  /// Climbs to `altitude_m` above home. Of a PX4 whose home is unknown it writes MIS_TAKEOFF_ALT,
  /// and puts it back once the vehicle is in the air or disarmed, or has not accepted; a value that
  /// is set meanwhile stays. Any disarm ends it.
  /// @param not_hil  of this and the next: consents to a vehicle that does not say that it is in
  ///     HIL. Takeoffs need it as arming does, others for an armed vehicle; what stops a vehicle
  ///     (land, hold, return_home, modes that do so) never does
  void takeoff(std::uint8_t system, double altitude_m, base::RunTime now, Done done,
               bool not_hil = false);
  void land(std::uint8_t system, base::RunTime now, Done done);
  void hold(std::uint8_t system, base::RunTime now, Done done);
  void return_home(std::uint8_t system, base::RunTime now, Done done);

  /// A place in the vehicle's local frame N, in m, and a heading in degrees.
  struct Target {
    double north_m = 0;
    double east_m = 0;
    double down_m = 0;
    std::optional<double> yaw_deg;
    /// Radius of the circle about the place, for a vehicle on its wing; below 0: counter-clockwise.
    std::optional<double> radius_m{};
  };
  void go_to(std::uint8_t system, const Target& target, base::RunTime now, Done done,
             bool not_hil = false);
  /// Done when the HEARTBEAT shows the mode; a refusal says which one it shows instead.
  void set_mode(std::uint8_t system, std::string_view word, base::RunTime now, Done done,
                bool not_hil = false);
  /// Period of a message on the vehicle's link; 0 the vehicle's default, negative off.
  void message_interval(std::uint8_t system, std::uint32_t message_id, double period_us,
                        base::RunTime now, Done done);

  /// Stick positions from -1 to 1; throttle from 0 to 1.
  struct Sticks {
    double pitch = 0;  ///< forward is positive
    double roll = 0;   ///< right is positive
    double throttle = 0;
    double yaw = 0;  ///< clockwise is positive
    std::uint16_t buttons = 0;
  };
  /// MANUAL_CONTROL once; nothing acknowledges it. Vehicles take gestures of sticks as commands to
  /// arm, so the interlock holds here too.
  void manual_control(std::uint8_t system, const Sticks& sticks, bool not_hil, base::RunTime now,
                      Done done);
  void reboot(std::uint8_t system, base::RunTime now, Done done, bool not_hil = false);
  /// Acknowledges a part of a vehicle's log, so that it sends on; does nothing for an unknown
  /// vehicle.
  using LogAnswer = std::variant<mavlink::common::LoggingAck, mav::services::RemoteLogBlockStatus>;
  void answer_log(std::uint8_t system, const LogAnswer& answer);
  /// Any other command, through the same interlock.
  void command(std::uint8_t system, const VehicleCommand& command, bool not_hil, base::RunTime now,
               Done done);

  void read_param(std::uint8_t system, const std::string& name, base::RunTime now, Done done);
  /// The interlock holds for what arms, permits to arm or drives an output, but not for the way
  /// into HIL. Each repetition asks again.
  void set_param(std::uint8_t system, const std::string& name, double value, base::RunTime now,
                 Done done, bool not_hil = false);
  void list_params(std::uint8_t system, base::RunTime now, Done done);
  /// Progress of the list of parameters that a vehicle sends; nullopt: none is under way.
  std::optional<mav::services::ListProgress> list_progress(std::uint8_t system) const;
  /// The type in the newest PARAM_VALUE of a parameter.
  std::optional<mavlink::common::MavParamType> param_type(std::uint8_t system,
                                                          const std::string& name) const;

  /// Sets the given gains of a loop one after the other, then answers with all it has; without
  /// values it only reads them.
  void set_gains(std::uint8_t system, const GainLoop& loop, const GainValues& values,
                 base::RunTime now, Done done, bool not_hil = false);

 private:
  std::unique_ptr<KnownVehicle> make(VehicleState state);
  template <class M>
  void send(const VehicleState& vehicle, M message);
  KnownVehicle* known(std::uint8_t system, const Done& done);
  static bool has_stopped_telling(const KnownVehicle& vehicle, base::RunTime now);
  void greet(KnownVehicle& vehicle, base::RunTime now);
  struct RateRound;
  void ask_for_rates(std::uint8_t system, const std::shared_ptr<RateRound>& round);
  void on_status_text(KnownVehicle& vehicle);
  void dispatch(KnownVehicle& vehicle, const mav::PacketView& packet, base::RunTime now);
  /// How a command is sent.
  struct Terms {
    bool not_hil = false;
    CommandExchange::Doubt doubt{};
    CommandExchange::Renewal renewal{};
  };
  void start(std::uint8_t system, const VehicleCommand& command, base::RunTime now, Done done,
             const Terms& terms);
  void start(std::uint8_t system, const VehicleCommand& command, base::RunTime now, Done done) {
    start(system, command, now, std::move(done), Terms{});
  }
  Done explained(const KnownVehicle& vehicle, Done done);
  std::optional<Outcome> interlock(const VehicleState& state, Motion motion, bool not_hil,
                                   base::RunTime now) const;
  bool interlocked(const KnownVehicle& vehicle, bool not_hil, base::RunTime now,
                   const Done& done) const;

  CommanderOptions options_;
  SendPacket send_;
  mav::Encoder encoder_;
  OwnHeartbeat heartbeat_;
  OnText on_text_;
  std::function<void(std::uint8_t, const VehicleCommand&, Done)> on_failure_;
  VehicleTable table_;
  Takeoff takeoff_;
  base::RunTime now_{};
};

}  // namespace cas::casd

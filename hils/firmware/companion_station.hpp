// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "base/earth/geodesy.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "hils/firmware/setpoint_stream.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/firmware_record.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/mission_exchange.hpp"

namespace cas::hils {

/// The sticks of a remote control as MANUAL_CONTROL, on the vehicle's own clock. No I/O; the
/// vehicle's time comes in.
class StickStream {
 public:
  /// As often as ground stations send them.
  static constexpr double kRate_hz = 25;

  /// From now on these sticks, until the end of the flight: PX4 takes their end for a lost remote
  /// control.
  void hold(const Sticks& sticks);
  /// Sends none from now on, or again: the radio is lost. Their time goes on.
  void lose(bool lost) { lost_ = lost; }
  /// For how long these sticks have been held, by the vehicle's clock.
  base::Duration held_for() const { return since_ ? newest_ - *since_ : base::Duration{}; }

  /// The vehicle's clock has gone on. @return the message that is due
  std::optional<mavlink::common::ManualControl> update(base::Duration vehicle_time);

 private:
  std::optional<Sticks> sticks_;
  bool lost_ = false;
  base::RateGate gate_{kRate_hz};
  std::optional<base::Duration> since_;  ///< nullopt: they were not sent yet
  base::Duration newest_{};
};

/// hils as a companion computer on a link of casd: streams setpoints and sticks on the vehicle's
/// clock and uploads missions. Pure: bytes and time come in, bytes go out.
class CompanionStation {
 public:
  using Send = std::function<void(std::span<const std::uint8_t>)>;

  static constexpr mav::Source kSelf = kCompanion;
  /// In the topology.
  static constexpr std::string_view kLink = "hils_companion";

  /// @param vehicle  system and component of the autopilot
  CompanionStation(mav::Source vehicle, Send send);

  void on_bytes(std::span<const std::uint8_t> bytes, base::RunTime now);
  void tick(base::RunTime now);

  /// The vehicle's clock (time_boot_ms of its position); nullopt until it was heard.
  std::optional<base::Duration> vehicle_time() const { return vehicle_time_; }
  SetpointStream& setpoints() { return setpoints_; }
  const SetpointStream& setpoints() const { return setpoints_; }

  StickStream& sticks() { return sticks_; }

  /// Tells the vehicle where its local frame begins (SET_GPS_GLOBAL_ORIGIN), with each
  /// ESTIMATOR_STATUS that knows a place about an origin of its own and none on the earth: that of
  /// a PX4 that flies by external vision, which does not hold a place without a home.
  void set_origin(const base::Geodetic& origin) { origin_ = origin; }

  /// Begins an upload; uploaded() has its end.
  void upload(mav::services::MissionExchange::Items items, base::RunTime now);
  const std::optional<mav::services::Outcome>& uploaded() const { return uploaded_; }
  /// The last item of the uploaded mission that the vehicle says it has reached.
  std::optional<std::uint16_t> reached() const { return reached_; }

 private:
  void on_packet(const mav::PacketView& packet, base::RunTime now);
  void on_vehicle_time(std::uint32_t boot_ms);
  void on_estimator(mavlink::common::EstimatorStatusFlags flags);
  template <class Message>
  void say(Message message);

  mav::Source vehicle_;
  Send send_;
  mav::Encoder encode_{kSelf};
  mav::Encoder encode_sticks_{kCompanionSticks};
  mav::PacketParser parser_;
  SetpointStream setpoints_;
  StickStream sticks_;
  mav::services::MissionExchange mission_;
  std::optional<base::Duration> vehicle_time_;
  std::optional<mav::services::Outcome> uploaded_;
  std::optional<std::uint16_t> reached_;
  std::optional<base::Geodetic> origin_;
  base::RunTime next_heartbeat_{};
};

}  // namespace cas::hils

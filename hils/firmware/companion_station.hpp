// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "base/time/clock.hpp"
#include "hils/firmware/setpoint_stream.hpp"
#include "hils/firmware/stick_stream.hpp"
#include "hils/measure/firmware_record.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/mission_exchange.hpp"

namespace cas::hils {

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

  /// Begins an upload; uploaded() has its end.
  void upload(mav::services::MissionExchange::Items items, base::RunTime now);
  const std::optional<mav::services::Outcome>& uploaded() const { return uploaded_; }
  /// The last item of the uploaded mission that the vehicle says it has reached.
  std::optional<std::uint16_t> reached() const { return reached_; }

 private:
  void on_packet(const mav::PacketView& packet, base::RunTime now);
  void on_vehicle_time(std::uint32_t boot_ms);
  template <class Message>
  void say(Message message);

  mav::Source vehicle_;
  Send send_;
  mav::Encoder encode_{kSelf};
  mav::PacketParser parser_;
  SetpointStream setpoints_;
  StickStream sticks_;
  mav::services::MissionExchange mission_;
  std::optional<base::Duration> vehicle_time_;
  std::optional<mav::services::Outcome> uploaded_;
  std::optional<std::uint16_t> reached_;
  base::RunTime next_heartbeat_{};
};

}  // namespace cas::hils

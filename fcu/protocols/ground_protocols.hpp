// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "base/time/clock.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/core/pilot_input.hpp"
#include "fcu/flight/flight_status.hpp"
#include "fcu/flight/status_texts.hpp"
#include "fcu/protocols/command_handler.hpp"
#include "fcu/protocols/mission_protocol.hpp"
#include "fcu/protocols/param_protocol.hpp"
#include "fcu/protocols/telemetry.hpp"
#include "fcu/protocols/vehicle_files.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/ping.hpp"
#include "mavlink/common/timesync.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::fcu {

struct FcuCore;

/// Everything that ground stations, companions and pilots say and hear: commands, parameters,
/// missions, setpoints, sticks, telemetry, files. The HIL stream is not among it.
class GroundProtocols {
 public:
  /// Collaborators; all outlive the protocols.
  struct View {
    const FcuCore& core;  ///< for telemetry
    CommandTarget target;
    Outbox& outbox;
    StatusTexts& texts;
    PilotInput& pilot;
    std::optional<base::RunTime>& ground_station_heard;
    std::function<void()> apply_params;  ///< passes changed parameters on
  };
  explicit GroundProtocols(View view);

  /// One packet that is meant for us.
  void on_packet(const mav::PacketView& packet, base::RunTime now);
  VehicleFiles& files() { return files_; }
  /// Streams, lists, repeats, status texts: whatever time makes due.
  void update(base::RunTime now);

 private:
  bool on_link_packet(const mav::PacketView& packet, base::RunTime now);
  bool on_command_packet(const mav::PacketView& packet, base::RunTime now);
  bool on_param_packet(const mav::PacketView& packet);
  bool on_file_packet(const mav::PacketView& packet, base::RunTime now);
  bool on_setpoint_packet(const mav::PacketView& packet, base::RunTime now);
  bool on_mission_packet(const mav::PacketView& packet, base::RunTime now);
  void send_texts();
  void hurry_after_a_change();

  View view_;
  Telemetry telemetry_;
  ParamProtocol params_;
  CommandHandler commands_;
  MissionProtocol missions_;
  VehicleFiles files_;
  mav::services::FtpServer file_server_;
  std::uint16_t long_texts_ = 0;
  bool was_armed_ = false;
  FlightMode was_mode_ = FlightMode::kHold;
  LandedState was_landed_ = LandedState::kOnGround;
};

}  // namespace cas::fcu

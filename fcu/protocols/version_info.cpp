// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/version_info.hpp"

#include <array>

#include "fcu/core/fcu_core.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::fcu {

using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

struct ModeInfo {
  FlightMode mode;
  MavStandardMode standard;
  const char* title;
};

constexpr std::array<ModeInfo, 9> kModes{{
    {FlightMode::kPosition, MavStandardMode::kPositionHold, "Position"},
    {FlightMode::kAltitude, MavStandardMode::kAltitudeHold, "Altitude"},
    {FlightMode::kStabilized, MavStandardMode::kNonStandard, "Stabilized"},
    {FlightMode::kTakeoff, MavStandardMode::kTakeoff, "Takeoff"},
    {FlightMode::kHold, MavStandardMode::kNonStandard, "Hold"},
    {FlightMode::kMission, MavStandardMode::kMission, "Mission"},
    {FlightMode::kReturn, MavStandardMode::kSafeRecovery, "Return"},
    {FlightMode::kLand, MavStandardMode::kLand, "Land"},
    {FlightMode::kOffboard, MavStandardMode::kNonStandard, "Offboard"},
}};

}  // namespace

void send_autopilot_version(FcuCore& core, base::RunTime, int version) {
  using C = MavProtocolCapability;
  AutopilotVersion m;
  m.capabilities = C::kMissionInt | C::kParamFloat | C::kCommandInt | C::kParamEncodeBytewise |
                   C::kSetAttitudeTarget | C::kSetPositionTargetLocalNed |
                   C::kSetPositionTargetGlobalInt | C::kFlightTermination | C::kMavlink2;
  // major, minor, patch, FIRMWARE_VERSION_TYPE_OFFICIAL: a release that ground stations know the
  // modes and parameters of.
  m.flight_sw_version = 1U << 24U | 15U << 16U | 0U << 8U | 255U;
  m.uid = core.config.system_id;
  core.outbox.reply(m, version);
}

void send_protocol_version(FcuCore& core, base::RunTime, int version) {
  ProtocolVersion m;
  m.version = 200;
  m.min_version = 100;
  m.max_version = 200;
  core.outbox.reply(m, version);
}

void send_available_modes(FcuCore& core, base::RunTime, int version) {
  for (std::size_t i = 0; i < kModes.size(); ++i) {
    AvailableModes m;
    m.number_modes = static_cast<std::uint8_t>(kModes.size());
    m.mode_index = static_cast<std::uint8_t>(i + 1);
    m.standard_mode = kModes[i].standard;
    m.custom_mode = px4_custom_mode(kModes[i].mode);
    mav::set_text(m.mode_name, kModes[i].title);
    core.outbox.reply(m, version);
  }
}

void send_current_mode(FcuCore& core, base::RunTime, int version) {
  CurrentMode m;
  for (const ModeInfo& info : kModes) {
    if (info.mode == core.commander.mode()) m.standard_mode = info.standard;
  }
  m.custom_mode = px4_custom_mode(core.commander.mode());
  m.intended_custom_mode = m.custom_mode;
  core.outbox.reply(m, version);
}

}  // namespace cas::fcu

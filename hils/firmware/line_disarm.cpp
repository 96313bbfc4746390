// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/line_disarm.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <chrono>

#include "base/time/clock.hpp"
#include "casd/transport/serial_device.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {
namespace {

constexpr base::Duration kLinePatience = std::chrono::seconds(3);
constexpr int kBetweenDisarms_ms = 200;
constexpr mav::Source kInsteadOfCasd{254, 190};

mavlink::common::CommandLong forced_disarm(mav::Source vehicle) {
  constexpr float kForce = 21196;  // of MAV_CMD_COMPONENT_ARM_DISARM, parameter 2
  mavlink::common::CommandLong command;
  command.target_system = vehicle.system;
  command.target_component = vehicle.component;
  command.command = mavlink::common::MavCmd::kComponentArmDisarm;
  command.param1 = 0;
  command.param2 = kForce;
  return command;
}

/// Reads the line: whether the vehicle's newest HEARTBEAT there is of a disarmed vehicle.
bool hears_disarmed(int line, mav::PacketParser& parser, mav::Source vehicle) {
  std::array<std::uint8_t, 4096> buffer;
  const ssize_t size = ::read(line, buffer.data(), buffer.size());
  bool disarmed = false;
  if (size <= 0) return false;
  parser.feed(std::span(buffer).first(static_cast<std::size_t>(size)),
              [&](const mav::PacketView& packet) {
                const auto beat = mav::decode<mavlink::common::Heartbeat>(packet);
                if (!beat || packet.source != vehicle) return;
                disarmed = !has(beat->base_mode, mavlink::common::MavModeFlag::kSafetyArmed);
              });
  return disarmed;
}

}  // namespace

std::optional<std::string> disarm_by_line(const FcuDevice& line, mav::Source vehicle) {
  casd::SerialRefusal refusal;
  const base::Descriptor device =
      casd::open_serial(line.path, {.baud = line.baud, .unlocked_pty = true}, refusal);
  if (!device) return refusal.sentence;
  mav::Encoder encoder(kInsteadOfCasd);
  mav::PacketParser parser(mavlink::common::table());
  const base::RunTime end = base::steady_now() + kLinePatience;
  while (base::steady_now() < end) {
    const auto packet = encoder(forced_disarm(vehicle));
    if (::write(device.get(), packet.data(), packet.size()) < 0) return line.path + " is gone";
    const base::RunTime next = base::steady_now() + std::chrono::milliseconds(kBetweenDisarms_ms);
    while (base::steady_now() < next) {
      pollfd readable{device.get(), POLLIN, 0};
      ::poll(&readable, 1, kBetweenDisarms_ms / 10);
      if (hears_disarmed(device.get(), parser, vehicle)) return std::nullopt;
    }
  }
  return "on " + line.path + " it does not say that it is disarmed";
}

}  // namespace cas::hils

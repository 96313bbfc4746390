// SPDX-License-Identifier: BSD-3-Clause
// Prints HEARTBEAT and ATTITUDE of a MAVLink stream on standard input:
//
//   nc -lu 14550 | mavlink_inspector
//   1/1 HEARTBEAT MAV_TYPE_QUADROTOR armed
//   1/1 ATTITUDE roll 0.10 pitch -0.20 yaw 1.50 rad
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string_view>

#include "mavlink/common/all.hpp"
#include "mavlink/common/enum_text.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace {

using namespace cas::mav;
namespace common = mavlink::common;

/// One overload for each message of interest; dispatch() passes over all others.
struct Printer {
  Source from;

  void operator()(const common::Heartbeat& heartbeat) const {
    const std::string_view type = name_of(heartbeat.type);
    const bool armed = has(heartbeat.base_mode, common::MavModeFlag::kSafetyArmed);
    std::printf("%d/%d HEARTBEAT %.*s %s\n", from.system, from.component,
                static_cast<int>(type.size()), type.data(), armed ? "armed" : "disarmed");
  }
  void operator()(const common::Attitude& attitude) const {
    std::printf("%d/%d ATTITUDE roll %.2f pitch %.2f yaw %.2f rad\n", from.system, from.component,
                double{attitude.roll}, double{attitude.pitch}, double{attitude.yaw});
  }
};

}  // namespace

int main() {
  PacketParser parser(common::table());
  std::array<std::uint8_t, 4096> bytes{};
  // read() returns the waiting bytes; fread() would wait until the buffer is full.
  for (ssize_t size; (size = ::read(STDIN_FILENO, bytes.data(), bytes.size())) > 0;) {
    parser.feed(std::span(bytes).first(static_cast<std::size_t>(size)),
                [](const PacketView& packet) { common::dispatch(packet, Printer{packet.source}); });
  }
}

// SPDX-License-Identifier: BSD-3-Clause
// Uploads way-points, LATITUDE LONGITUDE HEIGHT in each line of standard input, to the autopilot
// 1/1 at the other end of a serial line, then prints the autopilot's mission:
//
//   echo 47.3977420 8.5455940 10 | mavlink_mission_upload /dev/ttyACM0
//   0: 47.3977420 8.5455940 10.0
//
// A line that is no way-point, or none at all, is refused before anything is sent.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <variant>

#include "line.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/mission_exchange.hpp"

using namespace cas::mav;
using namespace cas::mav::services;

namespace {

/// Nothing where a line is no way-point, or there is none: an empty mission would clear the
/// vehicle's.
std::optional<MissionExchange::Items> read_items() {
  MissionExchange::Items items;
  for (std::string text; std::getline(std::cin, text);) {
    std::istringstream words(text);
    double lat = 0, lon = 0, height = 0;
    if (!(words >> lat >> lon >> height) || !(words >> std::ws).eof()) return std::nullopt;
    if (std::abs(lat) > 90 || std::abs(lon) > 180 || std::abs(height) > 100e3) return std::nullopt;
    items.push_back({.frame = mavlink::common::MavFrame::kGlobalRelativeAltInt,
                     .command = mavlink::common::MavCmd::kNavWaypoint,
                     .autocontinue = 1,
                     .x = static_cast<std::int32_t>(std::lround(lat * 1e7)),
                     .y = static_cast<std::int32_t>(std::lround(lon * 1e7)),
                     .z = static_cast<float>(height)});
  }
  return items.empty() ? std::nullopt : std::optional(items);
}

}  // namespace

int main(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  constexpr Source kSelf{.system = 255, .component = 190};
  Line line(argc == 2 ? argv[1] : "");
  if (!line.is_open()) {
    std::cerr << "usage: mavlink_mission_upload DEVICE < WAYPOINTS\n";
    return 2;
  }
  const auto items = read_items();
  if (!items) {
    std::cerr
        << "each line must be LATITUDE LONGITUDE HEIGHT, in degrees and m; nothing was sent\n";
    return 2;
  }
  Encoder encode_packet(kSelf);
  MissionExchange mission([&](const MissionExchange::Message& message) {
    std::visit([&](const auto& m) { line.send(encode_packet(addressed(m, {1, 1}))); }, message);
  });
  bool ok = false;
  mission.upload(*items, Clock::now(), [&](const Outcome& sent, const auto&) {
    if (!sent.ok()) return static_cast<void>(std::cerr << sent.message << '\n');
    mission.download(Clock::now(), [&](const Outcome& came, const MissionExchange::Items& theirs) {
      ok = came.ok();
      for (const auto& item : theirs) {
        std::printf("%d: %.7f %.7f %.1f\n", item.seq, item.x * 1e-7, item.y * 1e-7, double{item.z});
      }
    });
  });
  PacketParser parser(mavlink::common::table());
  while (mission.busy()) {
    parser.feed(line.read(), [&](const PacketView& packet) {
      if (packet.source.system == 1) mission.on_packet(packet, kSelf, Clock::now());
    });
    mission.tick(Clock::now());  // repeats unanswered messages
  }
  return ok ? 0 : 1;
}

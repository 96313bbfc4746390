// SPDX-License-Identifier: BSD-3-Clause
// Prints all parameters of the autopilot 1/1 at the other end of a serial line:
//
//   mavlink_param_backup /dev/ttyACM0
//   MC_PITCH_P  6.5
//   MC_ROLL_P  6.5
#include <chrono>
#include <iostream>
#include <optional>
#include <variant>

#include "line.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/param_exchange.hpp"
#include "mavlink_gen/services/vehicle_state.hpp"

int main(int argc, char** argv) {
  using namespace cas::mav;
  using namespace cas::mav::services;
  using Clock = std::chrono::steady_clock;
  constexpr Source kVehicle{.system = 1, .component = 1};
  Line line(argc == 2 ? argv[1] : "");
  if (!line.is_open()) {
    std::cerr << "usage: mavlink_param_backup DEVICE\n";
    return 2;
  }
  Encoder encode_packet({.system = 255, .component = 190});
  ParamExchange params([&](const ParamExchange::Message& message) {
    std::visit([&](const auto& m) { line.send(encode_packet(addressed(m, kVehicle))); }, message);
  });
  VehicleState vehicle(kVehicle, Clock::now());  // knows how this autopilot encodes integers
  std::optional<Outcome> outcome;
  params.list(Clock::now(), [&](const Outcome& listed) { outcome = listed; });
  PacketParser parser(mavlink::common::table());
  while (!outcome) {
    parser.feed(line.read(), [&](const PacketView& packet) {
      if (packet.source != kVehicle) return;
      vehicle.on_packet(packet, Clock::now());
      const auto value = decode<mavlink::common::ParamValue>(packet);
      if (value) params.on_value(*value, vehicle.param_encoding(), Clock::now());
    });
    params.tick(Clock::now());  // repeats unanswered requests
  }
  for (const auto& [name, value] : outcome->parameters) {
    std::cout << name << "  " << number_text(value) << '\n';
  }
  if (!outcome->ok()) std::cerr << outcome->message << '\n';
  return outcome->ok() ? 0 : 1;
}

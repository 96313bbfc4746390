// SPDX-License-Identifier: BSD-3-Clause
// Sends HEARTBEAT once a second over UDP; a ground station at that address shows a new vehicle:
//
//   mavlink_hello 127.0.0.1 14550        until it is interrupted
//   mavlink_hello 127.0.0.1 14550 3      three of them
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/encode.hpp"

int main(int argc, char** argv) {
  namespace common = mavlink::common;
  sockaddr_in to{};
  to.sin_family = AF_INET;
  if (argc < 3 || ::inet_pton(AF_INET, argv[1], &to.sin_addr) != 1) {
    std::fprintf(stderr, "usage: mavlink_hello ADDRESS PORT [COUNT]\n");
    return 2;
  }
  to.sin_port = htons(static_cast<std::uint16_t>(std::atoi(argv[2])));
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  cas::mav::Encoder encode_packet({.system = 1, .component = 1});  // counts its packets
  for (int left = argc > 3 ? std::atoi(argv[3]) : -1; left != 0; --left) {
    const auto packet = encode_packet(common::Heartbeat{
        .type = common::MavType::kQuadrotor,
        .autopilot = common::MavAutopilot::kGeneric,
        .system_status = common::MavState::kStandby,
    });
    const auto* address = reinterpret_cast<const sockaddr*>(&to);
    if (::sendto(socket, packet.data(), packet.size(), 0, address, sizeof to) < 0) {
      std::perror("mavlink_hello: sendto");
      return 1;
    }
    if (left != 1) std::this_thread::sleep_for(std::chrono::seconds(1));
  }
}

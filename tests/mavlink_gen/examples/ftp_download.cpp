// SPDX-License-Identifier: BSD-3-Clause
// Lists a folder of the autopilot 1/1 at the other end of a serial line (a path that ends in '/'),
// or writes one of its files to standard output:
//
//   mavlink_ftp_download /dev/ttyACM0 /fs/microsd/log/
//   mavlink_ftp_download /dev/ttyACM0 /fs/microsd/log/a.ulg > a.ulg
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>

#include "line.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/ftp_exchange.hpp"

int main(int argc, char** argv) {
  using namespace cas::mav;
  using namespace cas::mav::services;
  using Clock = std::chrono::steady_clock;
  constexpr Source kSelf{.system = 255, .component = 190};
  constexpr Source kVehicle{.system = 1, .component = 1};
  constexpr auto is_control = [](unsigned char c) { return std::iscntrl(c) != 0; };
  Line line(argc == 3 ? argv[1] : "");
  if (!line.is_open()) {
    std::cerr << "usage: mavlink_ftp_download DEVICE PATH\n";
    return 2;
  }
  Encoder encode_packet(kSelf);
  // Each run begins with another number, since the vehicle remembers those of the run before.
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now().time_since_epoch());
  FtpExchange files(
      [&](const FtpExchange::Message& message) {
        line.send(encode_packet(addressed(message, kVehicle)));
      },
      {}, static_cast<std::uint16_t>(milliseconds.count()));
  std::optional<Outcome> outcome;
  const auto done = [&](const Outcome& ended, const FtpResult& result) {
    outcome = ended;
    if (!ended.ok()) return;
    for (FtpEntry entry : result.entries) {
      std::ranges::replace_if(entry.name, is_control, '?');  // a terminal would obey them
      std::cout << entry.name << (entry.folder ? "/" : "  " + std::to_string(entry.size)) << '\n';
    }
    std::cout.write(reinterpret_cast<const char*>(result.bytes.data()),
                    static_cast<std::streamsize>(result.bytes.size()));
  };
  const std::string path = argv[2];
  path.ends_with('/') ? files.list(path, Clock::now(), done)
                      : files.download(path, Clock::now(), done);
  PacketParser parser(mavlink::common::table());
  while (!outcome) {
    parser.feed(line.read(), [&](const PacketView& packet) {
      if (packet.source == kVehicle) files.on_packet(packet, kSelf, Clock::now());
    });
    files.tick(Clock::now());  // repeats unanswered requests
  }
  if (outcome->ok() && !std::cout.flush()) {
    outcome = failure(OutcomeKind::kRefused, "standard output cannot be written");
  }
  if (!outcome->ok()) std::cerr << outcome->message << '\n';
  return outcome->ok() ? 0 : 1;
}

// SPDX-License-Identifier: BSD-3-Clause
// A dialect of one's own, lab.xml beside this file: cas_mavlink_generate(lab lab.xml), or
// `mavlink_gen generate --with-runtime --out gen lab.xml`, makes mavlink/lab/*.hpp of it.
//
//   mavlink_own_dialect 21.5 | mavlink_own_dialect
//   1/158 LAB_TEMPERATURE 21.50 degC
#include <array>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink/lab/all.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

using namespace cas::mav;
namespace lab = mavlink::lab;

namespace {

struct Printer {
  Source from;
  void operator()(const lab::LabTemperature& message) const {
    std::printf("%d/%d LAB_TEMPERATURE %.2f degC\n", from.system, from.component,
                message.temperature_degc());
  }
};

void write(std::span<const std::uint8_t> packet) {
  std::fwrite(packet.data(), 1, packet.size(), stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) {
    Encoder encode_packet({.system = 1, .component = 158});
    lab::LabTemperature message;
    message.set_temperature_degc(std::atof(argv[1]));
    write(encode_packet(message));
    write(encode_packet(mavlink::common::Heartbeat{}));  // dialects meet on one line
    return 0;
  }
  PacketParser parser(lab::table());  // skips messages outside the table
  std::array<std::uint8_t, 4096> bytes{};
  while (const std::size_t size = std::fread(bytes.data(), 1, bytes.size(), stdin)) {
    parser.feed(std::span(bytes).first(size),
                [](const PacketView& packet) { lab::dispatch(packet, Printer{packet.source}); });
  }
}

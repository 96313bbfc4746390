// SPDX-License-Identifier: BSD-3-Clause
// Usage: stranger lab.xml. Exit code 0: sent messages came back, and the file agrees with the code.
#include "mavlink/common/all.hpp"
#include "mavlink/lab/all.hpp"
#include "mavlink_gen/json/message_codec.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"
#include "mavlink_gen/parser/dialect_table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/command_exchange.hpp"

int main(int, char** argv) {
  using namespace cas::mav;
  xml::Diagnostics diagnostics;
  const auto dialect = xml::load_dialect(argv[1], diagnostics);
  if (!dialect) return 1;
  const xml::DialectTable table(*dialect);
  PacketParser parser(table.table());
  Encoder encode_packet({.system = 1, .component = 1});
  bool same = false;
  parser.feed(encode_packet(mavlink::lab::LabTemperature{.temperature = 2150}),
              [&](const PacketView& packet) {
                const auto message = decode<mavlink::lab::LabTemperature>(packet);
                same = message && message->temperature_degc() == 21.5;
              });
  services::MessageCodec codec;
  codec.add(*dialect);
  int sent = 0;
  services::CommandExchange commands([&](const auto&) { ++sent; });
  commands.start(services::arm_command(true, false), {}, [](const auto&) {});
  return same && codec.name(50000) == "LAB_TEMPERATURE" && sent == 1 ? 0 : 1;
}

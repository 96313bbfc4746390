// SPDX-License-Identifier: BSD-3-Clause
// Signs the packets of a MAVLink stream, or says which ones are signed with a key:
//
//   mavlink_signing sign "pass phrase" < stream > signed
//   mavlink_signing check "pass phrase" < signed
//   1/1 HEARTBEAT accepted
//
// Messages outside dialect common are left out, with a note on standard error. Exit 1: no packet
// came, or one that was checked is not accepted.
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/signing.hpp"

using namespace cas::mav;

int main(int argc, char** argv) {
  const std::string_view what = argc == 3 ? argv[1] : "";
  if (what != "sign" && what != "check") {
    std::fprintf(stderr, "usage: mavlink_signing sign|check PASS_PHRASE < STREAM\n");
    return 2;
  }
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto unix_us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  const SigningTime clock = signing_time(static_cast<std::uint64_t>(unix_us));
  // A stream that is checked may be an old one: any time will do to begin with.
  Signing<> signing(signing_key(argv[2]), what == "sign" ? clock : 0);
  bool all_accepted = true;

  const auto on_packet = [&](const PacketView& packet) {
    const MessageInfo& message = *mavlink::common::table().find(packet.message_id);
    if (what == "sign") {
      std::array<std::uint8_t, kMaxPacketBytes> out{};
      const std::size_t size = signing.sign(packet, message.crc_extra, 1, out);  // on link 1
      std::fwrite(out.data(), 1, size, stdout);
      return;
    }
    const SignatureVerdict verdict = signing.verify(packet);
    all_accepted = all_accepted && accepted(verdict);
    const char* word = verdict == SignatureVerdict::kAccepted       ? "accepted"
                       : verdict == SignatureVerdict::kUnsigned     ? "not signed"
                       : verdict == SignatureVerdict::kBadSignature ? "not signed with this key"
                                                                    : "replayed";
    std::printf("%d/%d %.*s %s\n", packet.source.system, packet.source.component,
                static_cast<int>(message.name.size()), message.name.data(), word);
  };

  PacketParser parser(mavlink::common::table());
  std::array<std::uint8_t, 4096> bytes{};
  while (const std::size_t size = std::fread(bytes.data(), 1, bytes.size(), stdin)) {
    parser.feed(std::span(bytes).first(size), on_packet);
  }
  parser.flush(on_packet);
  const PacketParser::Stats& found = parser.stats();
  if (found.unknown_ids > 0) {
    std::fprintf(stderr, "left out: %ju packets of messages that dialect common does not have\n",
                 std::uintmax_t{found.unknown_ids});
    all_accepted = all_accepted && what == "sign";
  }
  if (found.packets == 0) std::fprintf(stderr, "no packet came\n");
  return found.packets > 0 && all_accepted ? 0 : 1;
}

// SPDX-License-Identifier: BSD-3-Clause
// MAVLink's C codec on the bytes that ours is measured with. Its headers are the user's own.
#include <common/mavlink.h>

#include "tests/bench/bench_codec.hpp"

namespace cas::bench {
namespace {

/// @return packets
std::size_t parse(std::span<const std::uint8_t> bytes) {
  mavlink_message_t message;
  mavlink_status_t status;
  std::size_t packets = 0;
  for (const std::uint8_t byte : bytes) {
    if (mavlink_parse_char(MAVLINK_COMM_0, byte, &message, &status) == 0) continue;
    const mavlink_message_t* found = &message;
    benchmark::DoNotOptimize(found);
    ++packets;
  }
  return packets;
}

}  // namespace

void add_c_codec() {
  const auto stream = mixed_stream();
  for (const std::size_t piece : {1, 8, 256}) {
    benchmark::RegisterBenchmark(("c_receive_mixed_in_pieces/" + std::to_string(piece)).c_str(),
                                 [stream, piece](benchmark::State& state) {
                                   mavlink_reset_channel_status(MAVLINK_COMM_0);
                                   measure(state, kStreamMessages, [&] {
                                     std::size_t packets = 0;
                                     in_pieces(stream, piece,
                                               [&](auto bytes) { packets += parse(bytes); });
                                     if (packets != kStreamMessages)
                                       state.SkipWithError("packets were lost");
                                   });
                                 });
  }
  for (const Hostile& hostile : hostile_streams()) {
    for (const std::size_t piece : kPieces) {
      benchmark::RegisterBenchmark(
          ("c_refuse_" + hostile.name + "/" + std::to_string(piece)).c_str(),
          [bytes = hostile.bytes, piece](benchmark::State& state) {
            mavlink_reset_channel_status(MAVLINK_COMM_0);
            measure(state, bytes.size(),
                    [&] { in_pieces(bytes, piece, [](auto part) { parse(part); }); });
          });
    }
  }
}

}  // namespace cas::bench

// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/runtime/signing.hpp"
#include "tests/bench/bench_codec.hpp"

// Every allocation of the program is counted: the codec must make none. Not inlined, lest GCC take
// malloc and delete for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++cas::bench::allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

using namespace cas::mav;
using cas::bench::in_pieces;
using cas::bench::kStreamMessages;
using cas::bench::measure;
namespace common = mavlink::common;

constexpr Source kSender{1, 200};

common::HilSensor hil_sensor(std::uint64_t time_us) {
  return {.time_usec = time_us,
          .xacc = 0.1F,
          .yacc = -0.2F,
          .zacc = -9.81F,
          .xgyro = 0.01F,
          .ygyro = 0.02F,
          .zgyro = -0.03F,
          .xmag = 0.2F,
          .ymag = 0.01F,
          .zmag = 0.4F,
          .abs_pressure = 1013.25F,
          .diff_pressure = 0.5F,
          .pressure_alt = 12.5F,
          .temperature = 21.5F,
          .fields_updated = static_cast<common::HilSensorUpdatedFlags>(0x1FFF),
          .id = 1};
}

void encode_hil_sensor(benchmark::State& state) {
  auto message = hil_sensor(1);
  Encoder encoder(kSender);
  measure(state, 1, [&] {
    ++message.time_usec;
    benchmark::DoNotOptimize(message);
    benchmark::DoNotOptimize(encoder(message).data());
    benchmark::ClobberMemory();
  });
}

void encode_hil_actuator_controls(benchmark::State& state) {
  common::HilActuatorControls message{.time_usec = 1};
  message.controls.fill(0.5F);
  Encoder encoder(kSender);
  measure(state, 1, [&] {
    ++message.time_usec;
    benchmark::DoNotOptimize(message);
    benchmark::DoNotOptimize(encoder(message).data());
    benchmark::ClobberMemory();
  });
}

template <class Hash>
void encode_signed(benchmark::State& state) {
  auto message = hil_sensor(1);
  Signing<Hash> signing(signing_key("bench"), 1);
  PacketBuffer buffer;
  std::uint8_t sequence = 0;
  measure(state, 1, [&] {
    ++message.time_usec;
    benchmark::DoNotOptimize(message);
    buffer.size = signing.encode(message, kSender, sequence++, 0, buffer.bytes);
    benchmark::DoNotOptimize(buffer);
    benchmark::ClobberMemory();
  });
}

std::vector<std::uint8_t> stream_of(std::size_t count, auto&& message_at) {
  std::vector<std::uint8_t> stream;
  Encoder encoder(kSender);
  for (std::size_t i = 0; i < count; ++i) {
    const auto bytes = message_at(i, encoder);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  return stream;
}

void receive_hil_sensor(benchmark::State& state) {
  const auto stream = stream_of(
      kStreamMessages, [](std::size_t i, Encoder& encoder) { return encoder(hil_sensor(i)); });
  PacketParser parser(common::table());
  measure(state, kStreamMessages, [&] {
    std::size_t packets = 0;
    parser.feed(stream, [&](const PacketView& packet) {
      auto message = decode<common::HilSensor>(packet);
      benchmark::DoNotOptimize(message);
      ++packets;
    });
    if (packets != kStreamMessages) state.SkipWithError("packets were lost");
  });
}

std::span<const std::uint8_t> mixed(std::size_t i, Encoder& encoder) {
  constexpr float kValue = 0.37F;
  switch (i % 10) {
    case 4:
      return encoder(common::HilGps{.time_usec = i,
                                    .fix_type = 3,
                                    .lat = 471234567,
                                    .lon = 81234567,
                                    .alt = 488000,
                                    .cog = 9000,
                                    .satellites_visible = 12,
                                    .id = 1,
                                    .yaw = 9000});
    case 7:
      return encoder(common::Attitude{.time_boot_ms = 5, .roll = kValue, .yawspeed = kValue});
    case 9:
      return encoder(common::Heartbeat{.type = common::MavType::kQuadrotor});
    case 1:
    case 3:
    case 6: {
      common::HilActuatorControls controls{.time_usec = i};
      controls.controls.fill(kValue);
      return encoder(controls);
    }
    default:
      return encoder(hil_sensor(i));
  }
}

void receive_mixed(benchmark::State& state) {
  const auto stream = cas::bench::mixed_stream();
  PacketParser parser(common::table());
  state.counters["bytes_each"] = static_cast<double>(stream.size()) / kStreamMessages;
  measure(state, kStreamMessages, [&] {
    std::size_t packets = 0;
    parser.feed(stream, [&](const PacketView& packet) {
      benchmark::DoNotOptimize(packet.payload.data());
      ++packets;
    });
    if (packets != kStreamMessages) state.SkipWithError("packets were lost");
  });
}

void receive_and_dispatch_mixed(benchmark::State& state) {
  const auto stream = cas::bench::mixed_stream();
  PacketParser parser(common::table());
  measure(state, kStreamMessages, [&] {
    parser.feed(stream, [&](const PacketView& packet) {
      common::dispatch(packet, [](const auto& message) { benchmark::DoNotOptimize(&message); });
    });
  });
}

void receive_in_pieces(benchmark::State& state, const MessageTable& table) {
  const auto stream = cas::bench::mixed_stream();
  PacketParser parser(table);
  const auto piece = static_cast<std::size_t>(state.range(0));
  measure(state, kStreamMessages, [&] {
    const auto before = parser.stats().packets;
    in_pieces(stream, piece, [&](auto bytes) {
      parser.feed(
          bytes, [](const PacketView& packet) { benchmark::DoNotOptimize(packet.payload.data()); });
    });
    if (parser.stats().packets != before + kStreamMessages) {
      state.SkipWithError("packets were lost");
    }
  });
}

void receive_mixed_in_pieces(benchmark::State& state) { receive_in_pieces(state, common::table()); }
void receive_mixed_public(benchmark::State& state) { receive_in_pieces(state, public_table()); }

/// Bytes in which there is little to find, or nothing: a "message" is a byte.
void add_bytes(const std::string& name, const std::vector<std::uint8_t>& bytes,
               const MessageTable& table, double seconds = 0) {
  for (const std::size_t piece : cas::bench::kPieces) {
    auto* run = benchmark::RegisterBenchmark(
        (name + "/" + std::to_string(piece)).c_str(), [=](benchmark::State& state) {
          PacketParser parser(table);
          measure(state, bytes.size(), [&] {
            in_pieces(bytes, piece, [&](auto part) {
              parser.feed(part, [](const PacketView& packet) {
                benchmark::DoNotOptimize(packet.payload.data());
              });
            });
          });
        });
    if (seconds > 0) run->MinTime(seconds);
  }
}

void add_hostile() {
  for (const auto& hostile : cas::bench::hostile_streams()) {
    add_bytes("refuse_" + hostile.name, hostile.bytes, common::table());
    add_bytes("refuse_public_" + hostile.name, hostile.bytes, public_table());
  }
}

/// Each file of a folder, repeated until it is as long as a read of a socket.
/// @return how many there are
std::size_t add_corpus(const std::filesystem::path& folder) {
  constexpr std::size_t kLeastBytes = 1500;
  constexpr double kSeconds = 0.02;  // there may be thousands
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<std::uint8_t> once{std::istreambuf_iterator<char>(file), {}};
    if (once.empty()) continue;
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < kLeastBytes) bytes.insert(bytes.end(), once.begin(), once.end());
    add_bytes("corpus/" + entry.path().filename().string(), bytes, common::table(), kSeconds);
    ++files;
  }
  return files;
}

void checksum_280_bytes(benchmark::State& state) {
  std::array<std::uint8_t, kMaxPacketBytes> bytes{};
  measure(state, 1, [&] {
    benchmark::DoNotOptimize(bytes);
    benchmark::DoNotOptimize(Crc16().update(bytes).value());
  });
}

BENCHMARK(encode_hil_sensor);
BENCHMARK(encode_hil_actuator_controls);
BENCHMARK(encode_signed<Sha256>);
BENCHMARK(encode_signed<BasicSha256<Sha256Portable>>);
BENCHMARK(receive_hil_sensor);
BENCHMARK(receive_mixed);
BENCHMARK(receive_and_dispatch_mixed);
BENCHMARK(receive_mixed_in_pieces)->Arg(1)->Arg(8)->Arg(256);
BENCHMARK(receive_mixed_public)->Arg(0)->Arg(1)->Arg(8)->Arg(256);
BENCHMARK(checksum_280_bytes);

}  // namespace

namespace cas::bench {

std::vector<std::uint8_t> mixed_stream() { return stream_of(kStreamMessages, mixed); }

std::vector<Hostile> hostile_streams() {
  constexpr std::size_t kRepetitions = 1000;
  const std::vector<std::pair<std::string, std::vector<std::uint8_t>>> patterns{
      {"FE_FF", {0xFE, 0xFF}},
      {"FE_FE_0A", {0xFE, 0xFE, 0x0A}},
      {"FE_03", {0xFE, 0x03}},
      {"FD_FF_00", {0xFD, 0xFF, 0x00}},
      {"FE", {0xFE, 0xFE}},
      {"FD_FD_00_00", {0xFD, 0xFD, 0x00, 0x00}},
      {"FD", {0xFD, 0xFD}},
      {"FD_FF_01", {0xFD, 0xFF, 0x01}},
      {"FD_FF_02", {0xFD, 0xFF, 0x02}}};
  std::vector<Hostile> streams;
  for (const auto& [name, pattern] : patterns) {
    Hostile& stream = streams.emplace_back(Hostile{name, {}});
    for (std::size_t i = 0; i < kRepetitions; ++i) {
      stream.bytes.insert(stream.bytes.end(), pattern.begin(), pattern.end());
    }
  }
  return streams;
}

}  // namespace cas::bench

/// Beside Google Benchmark's flags: --corpus FOLDER measures each of its files, too.
int main(int argc, char** argv) {
  std::vector<char*> arguments;
  for (int i = 0; i < argc; ++i) {
    if (std::string_view(argv[i]) != "--corpus") {
      arguments.push_back(argv[i]);
      continue;
    }
    if (++i == argc || add_corpus(argv[i]) == 0) {
      std::fputs("bench_mavlink: --corpus wants a folder with files\n", stderr);
      return 2;
    }
  }
  add_hostile();
#ifdef CAS_BENCH_C_CODEC
  cas::bench::add_c_codec();
#endif
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

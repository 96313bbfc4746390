// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/signing.hpp"

namespace {

std::atomic<std::uint64_t> allocations{0};

}  // namespace

// Every allocation of the program is counted: the codec must make none. Not inlined, lest GCC take
// malloc and delete for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

using namespace cas::mav;
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

/// Runs the loop and reports time and allocations for each message.
template <class Body>
void measure(benchmark::State& state, std::size_t messages, Body body) {
  const auto before = allocations.load();
  for (auto _ : state) body();
  const auto made = static_cast<double>(allocations.load() - before);
  const auto total = static_cast<double>(state.iterations()) * static_cast<double>(messages);
  state.SetItemsProcessed(static_cast<std::int64_t>(total));
  // An inverted rate: seconds for each message.
  state.counters["per_message"] =
      benchmark::Counter(total, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["allocations"] = made;
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

constexpr std::size_t kStreamMessages = 1000;

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

/// The simulator's traffic in miniature: sensors, controls, GPS and telemetry, 64 bytes on average.
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
  const auto stream = stream_of(kStreamMessages, mixed);
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
  const auto stream = stream_of(kStreamMessages, mixed);
  PacketParser parser(common::table());
  measure(state, kStreamMessages, [&] {
    parser.feed(stream, [&](const PacketView& packet) {
      common::dispatch(packet, [](const auto& message) { benchmark::DoNotOptimize(&message); });
    });
  });
}

/// Feeds pieces of a size, as a slow UART gives them.
void feed_pieces(PacketParser& parser, std::span<const std::uint8_t> stream, std::size_t piece) {
  for (std::size_t i = 0; i < stream.size(); i += piece) {
    const auto size = piece < stream.size() - i ? piece : stream.size() - i;
    parser.feed(stream.subspan(i, size),
                [](const PacketView& packet) { benchmark::DoNotOptimize(packet.payload.data()); });
  }
}

void receive_mixed_in_pieces(benchmark::State& state) {
  const auto stream = stream_of(kStreamMessages, mixed);
  PacketParser parser(common::table());
  measure(state, kStreamMessages,
          [&] { feed_pieces(parser, stream, static_cast<std::size_t>(state.range(0))); });
}

/// Patterns of starts of packets that never end well, one after the other: a "message" is a byte.
template <std::uint8_t... pattern>
void refuse(benchmark::State& state) {
  constexpr std::size_t kRepetitions = 1000;
  constexpr std::array<std::uint8_t, sizeof...(pattern)> kPattern{pattern...};
  std::vector<std::uint8_t> stream;
  for (std::size_t i = 0; i < kRepetitions; ++i) {
    stream.insert(stream.end(), kPattern.begin(), kPattern.end());
  }
  const auto piece = state.range(0) == 0 ? stream.size() : static_cast<std::size_t>(state.range(0));
  PacketParser parser(common::table());
  measure(state, stream.size(), [&] { feed_pieces(parser, stream, piece); });
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
BENCHMARK(refuse<0xFE, 0xFF>)->Arg(0)->Arg(1);
BENCHMARK(refuse<0xFE, 0xFE, 0x0A>)->Arg(0)->Arg(1);
BENCHMARK(refuse<0xFE, 0x03>)->Arg(0)->Arg(1);
BENCHMARK(refuse<0xFD, 0xFF, 0x00>)->Arg(0)->Arg(1);
BENCHMARK(refuse<0xFD, 0xFD, 0x00, 0x00>)->Arg(0)->Arg(1);
BENCHMARK(checksum_280_bytes);

}  // namespace

BENCHMARK_MAIN();

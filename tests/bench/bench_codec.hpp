// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cas::bench {

/// Allocations of the program so far.
inline std::atomic<std::uint64_t> allocations{0};

inline constexpr std::size_t kStreamMessages = 1000;
inline constexpr std::size_t kPieces[] = {0, 1, 8};  ///< of hostile bytes; 0: the whole

/// The simulator's traffic in miniature: sensors, controls, GPS and telemetry, 70 bytes on average.
std::vector<std::uint8_t> mixed_stream();

/// Starts of packets that never end well, one after the other.
struct Hostile {
  std::string name;  ///< its pattern in hexadecimal
  std::vector<std::uint8_t> bytes;
};
std::vector<Hostile> hostile_streams();

/// Calls `feed` with pieces of a size, as a slow UART gives them. @param piece  0: the whole
template <class Feed>
void in_pieces(std::span<const std::uint8_t> stream, std::size_t piece, Feed&& feed) {
  const std::size_t step = piece == 0 ? stream.size() : piece;
  for (std::size_t i = 0; i < stream.size(); i += step) {
    feed(stream.subspan(i, std::min(step, stream.size() - i)));
  }
}

/// Runs the loop and reports time and allocations for each message; of hostile bytes each byte is
/// one.
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

/// MAVLink's C codec on the same bytes, as c_...; only with CAS_MAVLINK_C_LIBRARY.
void add_c_codec();

}  // namespace cas::bench

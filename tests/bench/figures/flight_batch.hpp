// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "tests/bench/figures/flight_figures.hpp"

namespace cas::hils {

/// Flies one seed and writes its result, so many bytes.
using FlyInto = std::function<void(std::uint64_t seed, std::span<std::byte> result)>;

/// Flies the seeds of a batch in `batch.jobs` processes, because the physics engine runs once in a
/// process. Results come back through pipes, in the order of the seeds.
///
/// @param results  room for all of them, each of `results.size() / batch.flights` bytes
/// @throws std::runtime_error that names the flight without a result and how its process ended
void fly_in_processes(const FlightBatch& batch, const FlyInto& fly, std::span<std::byte> results);

/// Flies seeds first_seed, first_seed + 1, ... and returns the results of `fly(seed)` in their
/// order.
/// @throws std::runtime_error as fly_in_processes()
template <class Result, class Fly>
std::vector<Result> fly_batch(const FlightBatch& batch, Fly&& fly) {
  static_assert(std::is_trivially_copyable_v<Result>);
  std::vector<Result> results(static_cast<std::size_t>(batch.flights));
  fly_in_processes(
      batch,
      [&fly](std::uint64_t seed, std::span<std::byte> bytes) {
        const Result result = fly(seed);
        const auto from = std::as_bytes(std::span(&result, 1));
        std::ranges::copy(from, bytes.begin());
      },
      std::as_writable_bytes(std::span(results)));
  return results;
}

}  // namespace cas::hils

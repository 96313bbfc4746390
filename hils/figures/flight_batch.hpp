// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "hils/figures/flight_figures.hpp"

namespace cas::hils {

/// Flies seeds first_seed, first_seed + 1, ... and returns what `fly(seed)` gave, in their order.
/// The physics engine runs once in a process, so each of the `jobs` is one, and sends its results
/// through a pipe.
template <class Result, class Fly>
std::vector<Result> fly_batch(const FlightBatch& batch, Fly&& fly) {
  static_assert(std::is_trivially_copyable_v<Result>);
  struct Job {
    pid_t pid = -1;
    std::FILE* results = nullptr;
  };
  std::vector<Job> jobs;
  for (int job = 0; job < batch.jobs; ++job) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    const pid_t pid = ::fork();
    if (pid < 0) throw std::runtime_error("no process");
    if (pid == 0) {
      ::close(ends[0]);
      std::FILE* out = ::fdopen(ends[1], "wb");
      try {
        for (int i = job; i < batch.flights; i += batch.jobs) {
          const Result result = fly(batch.first_seed + static_cast<std::uint64_t>(i));
          std::fwrite(&result, sizeof result, 1, out);
        }
      } catch (const std::exception& error) {
        std::fprintf(stderr, "flight_figures: %s\n", error.what());
        ::_exit(1);
      }
      std::fclose(out);
      ::_exit(0);
    }
    ::close(ends[1]);
    jobs.push_back({pid, ::fdopen(ends[0], "rb")});
  }

  std::vector<Result> results(static_cast<std::size_t>(batch.flights));
  bool whole = true;
  for (int i = 0; i < batch.flights; ++i) {
    std::FILE* from = jobs[static_cast<std::size_t>(i % batch.jobs)].results;
    whole =
        std::fread(&results[static_cast<std::size_t>(i)], sizeof(Result), 1, from) == 1 && whole;
  }
  for (const Job& job : jobs) {
    std::fclose(job.results);
    int status = 0;
    ::waitpid(job.pid, &status, 0);
  }
  if (!whole) throw std::runtime_error("a batch of flights broke off");
  return results;
}

}  // namespace cas::hils

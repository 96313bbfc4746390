// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace cas::sim {

/// A call or signal that changed the run.
struct NotedCall {
  std::int64_t unix_us = 0;
  double time_s = 0;  ///< simulated
  std::string client{};
  std::string method{};       ///< or the name of a signal
  std::string params = "{}";  ///< JSON
};

/// The newest calls that changed the run, for sim.journal. A program that flies in lockstep makes
/// thousands of calls: consecutive ones of a kind share an entry with a count, so that they do not
/// push out the calls of others.
class RunJournal {
 public:
  static constexpr std::size_t kMost = 1000;

  /// Adds a call. A further sim.run_until, or the same sim.step, of the same client with no other
  /// call in between counts up `times` of the newest entry, which then has the last parameters.
  void note(NotedCall call);

  /// {"calls": [...], "forgotten": N}, the oldest first; an entry has `times` if it is more than 1.
  nlohmann::json json() const;

 private:
  struct Entry {
    NotedCall call;
    std::uint64_t times = 1;
  };

  std::deque<Entry> entries_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace cas::sim

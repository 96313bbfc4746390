// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/time/clock.hpp"

namespace cas::casd {

/// The calls of the audit log, kept for casd.journal: the newest kMost of them.
class CallJournal {
 public:
  static constexpr std::size_t kMost = 1000;
  static constexpr std::size_t kMostParamsBytes = 1024;
  static constexpr std::size_t kMostRefusalBytes = 400;

  struct Call {
    base::RunTime at{};
    std::int64_t unix_us = 0;  ///< by the clock of a recording
    std::string client{};
    std::string method{};
    std::string params{};  ///< JSON
    std::uint8_t system = 0;
    std::optional<std::string> refusal{};  ///< nullopt: it was done
    std::uint64_t times = 1;
  };

  /// Parameters longer than kMostParamsBytes are dropped and longer refusals cut, so that an answer
  /// of kMost calls stays below the limit of a client's queue.
  void add(Call call);

  /// The newest call came again, with the same end.
  void again() { ++calls_.back().times; }

  /// {calls: [{at_s, unix_us, client, method, params, vehicle, refusal?, times?}], forgotten}: the
  /// oldest first, and how many older ones there were.
  nlohmann::json answer() const;

 private:
  std::deque<Call> calls_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace cas::casd

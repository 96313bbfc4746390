// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::base::rpc {

/// Share of a processor that all clients of a server may use together, with a burst of one second's
/// share. Above it each client waits, after a line, for (cost of the line) x (waiting clients) /
/// share, so a client with few requests hardly waits for busy ones. New clients are let in when the
/// total debt is earned back, or after a second. For one thread.
class ServeBudget {
 public:
  /// Longest wait, whatever a line has cost: a waiting client occupies a place.
  static constexpr Duration kLongestTurn = std::chrono::seconds(10);

  /// @param share  of one processor's time, above 0; 1 or more: all of it
  ServeBudget(double share, RunTime now)
      : share_(share), credit_s_(std::min(share, 1.0)), credited_(now) {}

  /// A line has cost that much. @return how long its client waits for its next one; zero: not
  Duration spend(Duration cost, RunTime now) {
    if (share_ >= 1) return Duration::zero();
    earn(now);
    credit_s_ = std::max(credit_s_ - to_seconds(cost), -share_);
    if (credit_s_ >= 0) return Duration::zero();
    const double turn_s = to_seconds(cost) * static_cast<double>(waiting_ + 1) / share_;
    return std::min(from_seconds(turn_s), kLongestTurn);
  }
  /// A client begins to wait for its turn, or has waited.
  void wait_begins() { ++waiting_; }
  void wait_ends() { --waiting_; }

  /// How long to wait until the next client is let in; zero: not.
  Duration before_next_client(RunTime now) {
    if (share_ >= 1) return Duration::zero();
    earn(now);
    return credit_s_ >= 0 ? Duration::zero() : from_seconds(-credit_s_ / share_);
  }

 private:
  void earn(RunTime now) {
    credit_s_ = std::min(share_, credit_s_ + to_seconds(now - credited_) * share_);
    credited_ = now;
  }

  double share_;
  double credit_s_;  ///< at least -share_: a debt of one second
  RunTime credited_;
  std::size_t waiting_ = 0;
};

}  // namespace cas::base::rpc

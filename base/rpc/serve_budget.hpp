// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "base/time/clock.hpp"

namespace cas::base::rpc {

/// How much of a processor's time all clients of a server may take together: a share, and that of a
/// second at once after a rest. Whoever has asked waits until the debt of all is earned back before
/// the next line is read; so clients that ask without a pause get equal turns, and one that asks
/// now and then is answered at once.
class ServeBudget {
 public:
  /// @param share  of one processor's time, above 0; 1 or more: all of it
  ServeBudget(double share, RunTime now)
      : share_(share), credit_s_(std::min(share, 1.0)), credited_(now) {}

  /// A line has cost that much. @return how long its client waits for its next one; zero: not
  Duration spend(Duration cost, RunTime now) {
    if (share_ >= 1) return Duration::zero();
    credit_s_ = std::min(share_, credit_s_ + to_seconds(now - credited_) * share_);
    credited_ = now;
    credit_s_ -= to_seconds(cost);
    return credit_s_ >= 0 ? Duration::zero() : from_seconds(-credit_s_ / share_);
  }

 private:
  double share_;
  double credit_s_;
  RunTime credited_;
};

}  // namespace cas::base::rpc

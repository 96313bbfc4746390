// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"

namespace cas::casd {

/// Detects a stalled line, one that accepts no more bytes, and decides the reaction. Pure.
///
/// A check costs system calls: after progress a line is not checked for half of the patience, and
/// counts as stalled after one and a half times the patience.
class Standstill {
 public:
  /// @param patience  longest that a line that lives leaves something unread
  explicit Standstill(base::Duration patience);

  base::Duration patience() const { return patience_; }
  /// The line was given something.
  void given(base::RunTime now) {
    if (since_ == base::RunTime{}) since_ = now;
  }
  /// Whether a check of the line begins now: bytes written from here on count.
  bool look_begins(base::RunTime now);
  /// Whether the last progress is so recent that no check is needed.
  bool rests(base::RunTime now) const { return now < rest_until_; }
  /// The line has made progress. @return whether its driver had been flushed meanwhile
  bool ended(base::RunTime now);
  /// Whether it was given something that it has not been seen to take.
  bool pending() const { return since_ != base::RunTime{}; }
  base::Duration lasts(base::RunTime now) const { return now - since_; }

  /// Whether to flush the driver's bytes now: once per standstill.
  bool flush_is_due(base::RunTime now);
  /// Whether to nudge the driver now: at growing intervals.
  bool nudge_is_due(base::RunTime now);
  /// When to look at the line again.
  base::RunTime next_look(base::RunTime now) const;

 private:
  base::Duration patience_;
  bool looked_at_ = true;
  base::RunTime rest_until_{};
  base::RunTime since_{};        ///< when it was given what it has not taken; zero: nothing
  base::Duration next_nudge_{};  ///< after so long a standstill
  bool flushed_ = false;         ///< in this standstill
};

}  // namespace cas::casd

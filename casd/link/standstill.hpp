// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/time/clock.hpp"

namespace cas::casd {

/// How long a line has taken none of the bytes written to it, and the remedy that is due. Pure.
///
/// A look at the line costs system calls: one that has just taken something is left in peace for
/// half of the patience, and is seen to stand still after one and a half times the patience.
class Standstill {
 public:
  /// @param patience  longest that a line that lives leaves something unread
  explicit Standstill(base::Duration patience);

  base::Duration patience() const { return patience_; }
  /// The line was given something.
  void given(base::RunTime now) {
    if (since_ == base::RunTime{}) since_ = now;
  }
  /// Whether the look at the line begins now: bytes written from here on count.
  bool look_begins(base::RunTime now);
  /// Whether it took something so little time ago that nobody looks.
  bool rests(base::RunTime now) const { return now < rest_until_; }
  /// The line has taken bytes. @return whether its driver had been emptied meanwhile
  bool ended(base::RunTime now);
  /// Whether it was given something that it has not been seen to take.
  bool pending() const { return since_ != base::RunTime{}; }
  base::Duration lasts(base::RunTime now) const { return now - since_; }

  /// Whether to discard the bytes that the driver holds: once in a standstill.
  bool flush_is_due(base::RunTime now);
  /// Whether the driver is to be nudged: after ever longer times.
  bool nudge_is_due(base::RunTime now);
  /// When to look at the line again.
  base::RunTime next_look(base::RunTime now) const;

 private:
  base::Duration patience_;
  bool looked_at_ = true;
  base::RunTime rest_until_{};
  base::RunTime since_{};        ///< of the oldest bytes not taken; zero: none
  base::Duration next_nudge_{};  ///< after so long a standstill
  bool flushed_ = false;         ///< in this standstill
};

}  // namespace cas::casd

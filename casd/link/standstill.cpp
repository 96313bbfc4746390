// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/standstill.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace cas::casd {
namespace {

// How long a line stands still before what its driver holds is thrown away, commands too: who sent
// them has long sent them again.
constexpr base::Duration kFlushAfter = std::chrono::seconds(1);
// A line that stands still is looked at after a sixteenth of the time that it has stood so far.
constexpr int kLookDivisor = 16;
constexpr base::Duration kShortestLook = std::chrono::milliseconds(1);
constexpr base::Duration kLongestLook = std::chrono::milliseconds(50);

}  // namespace

Standstill::Standstill(base::Duration patience) : patience_(patience), next_nudge_(2 * patience) {}

bool Standstill::look_begins(base::RunTime now) {
  if (looked_at_) return false;
  looked_at_ = true;
  since_ = now;
  return true;
}

bool Standstill::ended(base::RunTime now) {
  looked_at_ = false;
  rest_until_ = now + patience_ / 2;
  since_ = {};
  next_nudge_ = 2 * patience_;
  return std::exchange(flushed_, false);
}

bool Standstill::flush_is_due(base::RunTime now) {
  if (flushed_ || lasts(now) <= std::max(kFlushAfter, patience_)) return false;
  flushed_ = true;
  return true;
}

bool Standstill::nudge_is_due(base::RunTime now) {
  if (lasts(now) <= next_nudge_) return false;
  next_nudge_ = 2 * lasts(now);
  return true;
}

base::RunTime Standstill::next_look(base::RunTime now) const {
  return now + std::clamp(lasts(now) / kLookDivisor, kShortestLook, kLongestLook);
}

}  // namespace cas::casd

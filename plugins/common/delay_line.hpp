// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::sim {

/// Holds samples back for a fixed time, in order. Room is taken once: pushing into a full line
/// drops the oldest.
template <class T>
class DelayLine {
 public:
  DelayLine() = default;
  DelayLine(base::Duration delay, std::size_t capacity) : delay_(delay), slots_(capacity) {}

  void push(base::SimTime now, const T& value) { push_until(now + delay_, value); }

  /// Holds `value` back until `due`, and until all before it have gone.
  void push_until(base::SimTime due, const T& value) {
    if (slots_.empty()) return;
    if (size_ == slots_.size()) drop_front();
    slots_[(head_ + size_) % slots_.size()] = {due, value};
    ++size_;
  }

  /// The oldest sample whose delay is over, or nothing.
  std::optional<T> pop(base::SimTime now) {
    if (size_ == 0 || slots_[head_].due > now) return std::nullopt;
    std::optional<T> value = slots_[head_].value;
    drop_front();
    return value;
  }

  bool empty() const { return size_ == 0; }
  void clear() { head_ = size_ = 0; }
  base::Duration delay() const { return delay_; }

 private:
  struct Slot {
    base::SimTime due;
    T value{};
  };

  void drop_front() {
    head_ = (head_ + 1) % slots_.size();
    --size_;
  }

  base::Duration delay_{};
  std::vector<Slot> slots_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace cas::base {

/// Hands the newest value from one thread to another; older values are overwritten and counted.
/// Safe from any thread; a call holds a lock for one copy or move of T.
template <class T>
class Mailbox {
 public:
  /// Stores the value in place of one that has not been taken.
  void put(const T& value) {
    const std::scoped_lock lock(mutex_);
    if (value_) ++overwritten_;
    value_ = value;
  }
  /// The newest value since the last call, or nothing.
  std::optional<T> take() {
    const std::scoped_lock lock(mutex_);
    std::optional<T> taken = std::move(value_);
    value_.reset();
    return taken;
  }
  /// Values that nobody took.
  std::uint64_t overwritten() const {
    const std::scoped_lock lock(mutex_);
    return overwritten_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<T> value_;
  std::uint64_t overwritten_ = 0;
};

}  // namespace cas::base

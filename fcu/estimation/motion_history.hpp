// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "base/time/clock.hpp"

namespace cas::fcu {

/// Remembers by how much velocity and position changed, so that a measurement that comes late can
/// be compared with the state it was taken in. Corrections made in between do not disturb it.
class MotionHistory {
 public:
  /// How the state at an earlier time differs from the newest one.
  struct Change {
    double age_s = 0;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< v(now) - v(then)
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< p(now) - p(then) - v(then) * age
  };

  void clear() { size_ = 0; }

  /// Adds a step of length dt (s) with mean acceleration a_N (m/s^2) that ends at `time`.
  void add(base::SimTime time, double dt, const Eigen::Vector3d& a_N) {
    Entry next{time, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    if (size_ > 0) {
      const Entry& last = entry(0);
      next.s1 = last.s1 + a_N * dt;
      next.s2 = last.s2 + last.s1 * dt + a_N * (0.5 * dt * dt);
    }
    head_ = (head_ + 1) % kEntries;
    ring_[head_] = next;
    if (size_ < kEntries) ++size_;
  }

  /// Change since `time`; a time before the memory is taken as its oldest entry, one after the
  /// newest entry as now.
  Change since(base::SimTime time) const {
    Change change;
    if (size_ == 0 || time >= entry(0).time) return change;
    std::size_t back = 0;
    while (back + 1 < size_ && entry(back).time > time) ++back;
    const Entry& now = entry(0);
    const Entry& then = entry(back);
    change.age_s = base::to_seconds(now.time - then.time);
    change.velocity = now.s1 - then.s1;
    change.position = now.s2 - then.s2 - then.s1 * change.age_s;
    return change;
  }

 private:
  struct Entry {
    base::SimTime time;
    Eigen::Vector3d s1;  ///< integral of the acceleration
    Eigen::Vector3d s2;  ///< integral of s1
  };
  const Entry& entry(std::size_t back) const { return ring_[(head_ + kEntries - back) % kEntries]; }

  static constexpr std::size_t kEntries = 512;  // 1 s at 500 Hz
  std::array<Entry, kEntries> ring_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace cas::fcu

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
  void add(base::SimTime time, double dt, const Eigen::Vector3d& a_N);

  /// Change since `time`; a time before the memory is taken as its oldest entry, one after the
  /// newest entry as now.
  Change since(base::SimTime time) const;

 private:
  struct Entry {
    base::SimTime time;
    Eigen::Vector3d s1;  ///< integral of the acceleration
    Eigen::Vector3d s2;  ///< integral of s1
  };
  const Entry& entry(std::size_t back) const;

  static constexpr std::size_t kEntries = 512;  // 1 s at 500 Hz
  std::array<Entry, kEntries> ring_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace cas::fcu

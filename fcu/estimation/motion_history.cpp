// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/estimation/motion_history.hpp"

namespace cas::fcu {

const MotionHistory::Entry& MotionHistory::entry(std::size_t back) const {
  return ring_[(head_ + kEntries - back) % kEntries];
}

void MotionHistory::add(base::SimTime time, double dt, const Eigen::Vector3d& a_N) {
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

MotionHistory::Change MotionHistory::since(base::SimTime time) const {
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

}  // namespace cas::fcu

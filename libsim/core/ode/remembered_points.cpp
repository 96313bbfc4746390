// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/remembered_points.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {

namespace {

constexpr double kOutOfPlace = 5e-3;  // m: a point that has moved farther is another one

bool is_same(const ContactPoint& a, const ContactPoint& b) {
  return a.kind == b.kind && (a.p_W - b.p_W).norm() < kOutOfPlace &&
         std::abs(a.face_W.dot(b.face_W)) > kOneFace;
}

}  // namespace

void RememberedPoints::add_to(std::vector<ContactPoint>& points, const BodyMove& since_last) {
  const std::size_t fresh = points.size();
  const auto found_again = [&](const ContactPoint& old) {
    const auto end = points.begin() + static_cast<std::ptrdiff_t>(fresh);
    return std::any_of(points.begin(), end,
                       [&](const ContactPoint& point) { return is_same(point, old); });
  };
  std::erase_if(found_, [&](Found& old) {
    old.slid_m += since_last.carry(old.point);
    return old.point.depth_m < 0 || old.slid_m > kOutOfPlace || found_again(old.point);
  });
  for (const Found& old : found_) points.push_back(old.point);
  for (std::size_t i = 0; i < fresh && found_.size() < kMost; ++i) {
    if (points[i].face_W.isZero(0.0) || points[i].depth_m <= 0) continue;
    found_.push_back({points[i], 0});
  }
}

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/contact_patch.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cas::sim {

namespace {

constexpr double kBeyondAll = std::numeric_limits<double>::infinity();
constexpr double kSameNormal = 0.9659;  // cosine of 15 degrees
constexpr double kSameFace = 0.766;     // cosine of 40 degrees
constexpr double kDeeper = 1e-4;        // m
constexpr double kApart = 1e-4;         // m: points nearer than this count once
constexpr double kSame = 1e-9;          // m: points as far as this from something are as far
constexpr std::size_t kMostPatches = 8;

/// The points of one patch, seen in its plane.
struct Patch {
  std::size_t deepest;
  Eigen::Vector3d n_W;
  std::size_t kind;
  std::array<std::size_t, kMostOfPatch> kept{};
  std::size_t count = 0;

  bool holds(const ContactPoint& point) const {
    return point.kind == kind && point.n_W.dot(n_W) > kSameNormal;
  }
  void keep(std::size_t index) { kept[count++] = index; }
};

/// The point of the patch with the largest `measure`; that measure is written to `largest`.
template <class Measure>
std::size_t farthest(std::span<const ContactPoint> points, const Patch& patch, double& largest,
                     Measure measure) {
  std::size_t best = patch.deepest;
  largest = -kBeyondAll;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!patch.holds(points[i])) continue;
    const double value = measure(points[i].p_W);
    const bool as_far = std::abs(value - largest) <= kSame;
    // Of points that are equally far the deepest is taken: rounding does not decide.
    const bool better = as_far && points[i].depth_m > points[best].depth_m;
    if (value <= largest + kSame && !better) continue;
    largest = std::max(largest, value);
    best = i;
  }
  return best;
}

Eigen::Vector3d middle(std::span<const ContactPoint> points, const Patch& patch) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(kBeyondAll);
  Eigen::Vector3d high = -low;
  for (const ContactPoint& point : points) {
    if (!patch.holds(point)) continue;
    low = low.cwiseMin(point.p_W);
    high = high.cwiseMax(point.p_W);
  }
  return 0.5 * (low + high);
}

void keep_rim(std::span<const ContactPoint> points, Patch& patch) {
  const Eigen::Vector3d n = patch.n_W;
  const auto in_plane = [&n](const Eigen::Vector3d& d) -> Eigen::Vector3d {
    return d - n.dot(d) * n;
  };
  const Eigen::Vector3d centre = middle(points, patch);
  double reach = 0;
  patch.keep(farthest(points, patch, reach,
                      [&](const Eigen::Vector3d& p) { return in_plane(p - centre).norm(); }));
  const Eigen::Vector3d first = points[patch.kept[0]].p_W;
  const std::size_t second = farthest(
      points, patch, reach, [&](const Eigen::Vector3d& p) { return in_plane(p - first).norm(); });
  if (reach < kApart) return;
  patch.keep(second);
  const Eigen::Vector3d across = n.cross(in_plane(points[second].p_W - first)).normalized();
  for (const double side : {1.0, -1.0}) {
    const std::size_t third = farthest(points, patch, reach, [&](const Eigen::Vector3d& p) {
      return side * across.dot(p - first);
    });
    if (reach >= kApart) patch.keep(third);
  }
}

void keep_deepest(std::span<const ContactPoint> points, Patch& patch) {
  double depth = 0;
  for (std::size_t i = 0; i < patch.count; ++i) {
    depth = std::max(depth, points[patch.kept[i]].depth_m);
  }
  if (points[patch.deepest].depth_m > depth + kDeeper) patch.keep(patch.deepest);
}

/// The deepest point that belongs to none of the patches; the number of points where all do.
std::size_t deepest_left(std::span<const ContactPoint> points, std::span<const Patch> patches) {
  std::size_t best = points.size();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (best < points.size() && points[i].depth_m <= points[best].depth_m) continue;
    const bool taken = std::any_of(patches.begin(), patches.end(),
                                   [&](const Patch& patch) { return patch.holds(points[i]); });
    if (!taken) best = i;
  }
  return best;
}

/// Whether the point is pushed out of its triangle straight away from its face; true without one.
bool lies_on_face(const ContactPoint& point) {
  return point.face_W.isZero(0.0) || std::abs(point.n_W.dot(point.face_W)) > kSameNormal;
}

}  // namespace

void drop_inner_edges(std::vector<ContactPoint>& points) {
  const auto continues_a_face = [&points](const ContactPoint& edge) {
    return std::any_of(points.begin(), points.end(), [&edge](const ContactPoint& other) {
      return std::abs(edge.face_W.dot(other.n_W)) > kSameFace && lies_on_face(other);
    });
  };
  // Edges go to the end first, so that the points on faces stay in place during the comparison.
  const auto edges = std::partition(points.begin(), points.end(), lies_on_face);
  const auto last = std::remove_if(edges, points.end(), continues_a_face);
  points.erase(last, points.end());
}

void keep_outermost(std::span<const ContactPoint> points, std::vector<KeptContact>& kept) {
  kept.clear();
  std::array<Patch, kMostPatches> patches;
  for (std::size_t n = 0; n < kMostPatches && kept.size() < kMostContacts; ++n) {
    const std::size_t deepest = deepest_left(points, std::span(patches).first(n));
    if (deepest == points.size()) return;
    Patch& patch = patches[n];
    patch = {.deepest = deepest, .n_W = points[deepest].n_W, .kind = points[deepest].kind};
    keep_rim(points, patch);
    keep_deepest(points, patch);
    for (std::size_t i = 0; i < patch.count && kept.size() < kMostContacts; ++i) {
      kept.push_back({.index = patch.kept[i], .patch = n});
    }
  }
}

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/ode/contact_patch.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

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
    // The deepest of points that are equally far is taken, so that rounding does not decide.
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

namespace {

/// Depth-weighted moments of the points of one patch, in its plane.
struct Moments {
  double weight = 0;  // sum of the depths, m
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::Zero();     // mean normal, unit
  double depth_m = 0;                                // mean
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  // second moments about the centre, m^2

  explicit Moments(std::span<const ContactPoint> patch) {
    for (const ContactPoint& point : patch) {
      weight += point.depth_m;
      centre_W += point.depth_m * point.p_W;
      n_W += point.depth_m * point.n_W;
      depth_m += point.depth_m * point.depth_m;
    }
    if (!(weight > 0)) return;
    centre_W /= weight;
    depth_m /= weight;
    n_W.normalize();
    for (const ContactPoint& point : patch) {
      const Eigen::Vector3d d = point.p_W - centre_W;
      const Eigen::Vector3d flat = d - n_W.dot(d) * n_W;
      spread += point.depth_m / weight * flat * flat.transpose();
    }
  }

  /// Change of depth along a unit vector of the plane, by least squares.
  double slope_along(const Eigen::Vector3d& axis_W, double second_moment,
                     std::span<const ContactPoint> patch) const {
    double product = 0;
    for (const ContactPoint& point : patch) {
      product +=
          point.depth_m / weight * axis_W.dot(point.p_W - centre_W) * (point.depth_m - depth_m);
    }
    return product / second_moment;
  }
};

/// Appends the points that stand for a curved patch.
void add_support(std::span<const ContactPoint> patch, std::vector<ContactPoint>& out) {
  constexpr double kNoExtent_m2 = 1e-6;
  const Moments moments(patch);
  ContactPoint centre = patch.front();
  if (!(moments.weight > 0)) return out.push_back(centre);
  centre.p_W = moments.centre_W;
  centre.n_W = moments.n_W;
  centre.depth_m = moments.depth_m;
  centre.face_W.setZero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments.spread);
  const bool is_wide = axes.eigenvalues()[1] > kNoExtent_m2;
  const std::size_t before = out.size();
  for (const Eigen::Index i : {2, 1}) {
    const double second_moment = axes.eigenvalues()[i];
    if (second_moment <= kNoExtent_m2) continue;
    const Eigen::Vector3d axis_W = axes.eigenvectors().col(i);
    const double slope = moments.slope_along(axis_W, second_moment, patch);
    const double reach = std::sqrt(is_wide ? 2 * second_moment : second_moment);
    for (const double side : {reach, -reach}) {
      ContactPoint point = centre;
      point.p_W += side * axis_W;
      point.depth_m += side * slope;
      out.push_back(point);
    }
  }
  if (out.size() == before) out.push_back(centre);
}

}  // namespace

bool face_more_than_one_way(std::span<const ContactPoint> points) {
  if (points.empty() || points.front().face_W.isZero(0.0)) return false;
  return std::any_of(points.begin(), points.end(), [&](const ContactPoint& point) {
    return std::abs(point.face_W.dot(points.front().face_W)) < kOneFace;
  });
}

void spread_curved_patches(std::vector<ContactPoint>& points, std::vector<ContactPoint>& room) {
  if (!face_more_than_one_way(points)) return;
  room.clear();
  std::span<ContactPoint> left = points;
  for (std::size_t n = 0; n < kMostPatches && !left.empty(); ++n) {
    // Each patch is moved to the front of what is left, its deepest point first.
    const auto deepest =
        std::max_element(left.begin(), left.end(),
                         [](const auto& a, const auto& b) { return a.depth_m < b.depth_m; });
    std::iter_swap(left.begin(), deepest);
    const Patch patch{.deepest = 0, .n_W = left.front().n_W, .kind = left.front().kind};
    const auto end = std::partition(left.begin(), left.end(),
                                    [&patch](const auto& point) { return patch.holds(point); });
    const std::span<ContactPoint> own(left.begin(), end);
    if (face_more_than_one_way(own)) {
      add_support(own, room);
    } else {
      room.insert(room.end(), own.begin(), own.end());
    }
    left = std::span(end, left.end());
  }
  points.swap(room);
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

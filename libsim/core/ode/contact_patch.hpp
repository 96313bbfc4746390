// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "libsim/core/export.hpp"

namespace cas::sim {

/// Faces whose normals have a larger cosine between them (0.08 degree) count as one.
inline constexpr double kOneFace = 1 - 1e-6;

/// A point where two shapes overlap, as a collision finds it.
struct ContactPoint {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   ///< m
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  ///< unit, out of the touched shape
  double depth_m = 0;                              ///< of the overlap, along n_W
  std::size_t kind = 0;  ///< points of different kinds (surfaces, say) are never one patch
  /// Unit normal of the triangle that is touched, of either sign; zero where there is none.
  Eigen::Vector3d face_W = Eigen::Vector3d::Zero();
};

/// A contact point that counts, and the patch that it belongs to.
struct KeptContact {
  std::size_t index = 0;  ///< into the points given
  std::size_t patch = 0;  ///< from 0 in the order of depth
};

/// Most points that are kept of one patch: four at its rim, and the deepest.
inline constexpr std::size_t kMostOfPatch = 5;
/// Most points that are kept of all patches together.
inline constexpr std::size_t kMostContacts = 16;

/// Takes out contacts with edges that are none: where triangles continue a surface, a body that
/// lies on it overlaps the next one by a sliver and would be pushed back sideways, along the
/// shortest way out of that triangle alone. Such a point's normal is not its triangle's, while
/// another point's is, and the two triangles face the same way within 40 degrees.
CAS_SIM_EXPORT void drop_inner_edges(std::vector<ContactPoint>& points);

/// Whether the points are with triangles of which some face another way than the first.
CAS_SIM_EXPORT bool face_more_than_one_way(std::span<const ContactPoint> points);

/// Replaces the points of each patch on triangles that do not face one way by up to four.
///
/// On uneven ground the rim of an overlap has no depth, and which points a collision finds changes
/// with every micrometre: a body on the outermost or deepest of them never comes to rest. The four
/// move steadily with the body: they lie about the centre of the points' depths, along the
/// principal axes, with the second moments, the mean normal and the plane of depths of all (least
/// squares). A patch without extent along an axis has two points, or one.
/// @param room  to work in, so that nothing is taken from the heap in a step
CAS_SIM_EXPORT void spread_curved_patches(std::vector<ContactPoint>& points,
                                          std::vector<ContactPoint>& room);

/// Chooses those contacts that carry a body: the outermost of each patch.
///
/// Points of one kind whose normals differ by less than 15 degrees are one patch. Each patch keeps,
/// in its plane, the point farthest from its middle, the one farthest from that, and on each side
/// of the line between them the one farthest from it: the support of the body. It also keeps the
/// deepest point if that lies more than 0.1 mm deeper than all of these. So a flat surface of any
/// number of triangles has the same contacts as a plane. A pure function of the points; their order
/// decides between equal points.
///
/// @param kept  overwritten; at most kMostContacts
CAS_SIM_EXPORT void keep_outermost(std::span<const ContactPoint> points,
                                   std::vector<KeptContact>& kept);

}  // namespace cas::sim

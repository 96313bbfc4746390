// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ode/ode.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "libsim/core/export.hpp"
#include "libsim/core/ode/geometry.hpp"

namespace cas::sim {

/// A cylinder in its place.
struct PlacedCylinder {
  Eigen::Vector3d centre_W;  ///< m
  Eigen::Matrix3d R_WC;      ///< z of C along its axis
  double radius_m;
  double length_m;
};

/// Points by which a cylinder stands on flat ground: four at the rim of its lower base, a quarter
/// of a turn apart, and the lowest of its upper base (which touches when it lies). A base that is
/// in the ground all around has them in place on the cylinder, as the corners of a box are; of one
/// that leans further the first is its lowest point. So a standing cylinder rests as a box does,
/// and a leaning one rolls on its rim.
CAS_SIM_EXPORT std::array<Eigen::Vector3d, 5> base_points(const PlacedCylinder& cylinder,
                                                          const HalfSpace& ground);

/// Contacts of a cylinder with a plane, or with a box over one face of which its whole base is, by
/// base_points(); `out` has room for five. nullopt for other pairs: ODE has contacts of their own
/// for them.
std::optional<std::size_t> collide_base(dGeomID a, dGeomID b, std::span<dContactGeom> out);

}  // namespace cas::sim

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

/// A cylinder with its position and attitude.
struct PlacedCylinder {
  Eigen::Vector3d centre_W;  ///< m
  Eigen::Matrix3d R_WC;      ///< frame C of the cylinder: z along the axis
  double radius_m;
  double length_m;
};

/// Points in W, m, at which a cylinder can touch flat ground: four at the rim of its lower base, a
/// quarter of a turn apart, and the lowest point of its upper base (for a cylinder that lies). If
/// the whole rim is in the ground, the four are fixed to the cylinder, as the corners are to a box;
/// else the first is the lowest point of the rim. So a standing cylinder rests like a box, and a
/// leaning one rolls on its rim.
CAS_SIM_EXPORT std::array<Eigen::Vector3d, 5> base_points(const PlacedCylinder& cylinder,
                                                          const HalfSpace& ground);

/// Writes the contacts of a cylinder with a plane, or with a box whose face lies below the whole
/// base, to `out`: those of base_points() that are in the ground. `out` has room for five.
/// @return their number; nullopt for other pairs of shapes, whose contacts ODE finds
std::optional<std::size_t> collide_base(dGeomID a, dGeomID b, std::span<dContactGeom> out);

}  // namespace cas::sim

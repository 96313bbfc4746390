// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/config/aero.hpp"

#include "libsim/core/body/shape.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/model_loader.hpp"

namespace cas::sim {

/// A vehicle as its makers draw it, where it has wings or there is a mesh among its visuals; poses
/// in B, by their own names. Empty where none can be read, or they have more triangles than that:
/// then a stand-in is drawn.
/// @param warnings  takes a sentence with link and file for each mesh that cannot be read
CAS_SIM_EXPORT std::vector<Shape> load_visuals(const VehicleModel& model, bool has_wings,
                                               std::size_t most_triangles,
                                               std::vector<std::string>& warnings);

/// A visual that turns as a control surface does: about its front edge, x = size / 2 in its own
/// axes, which lies along its y.
struct DrawnSurface {
  std::size_t visual = 0;   ///< its index
  std::size_t surface = 0;  ///< index of the control surface
  double sign = 1;          ///< of its turn about its y by a deflection above 0
};

/// The boxes among a vehicle's visuals that are named as a control surface is, or so with _left or
/// _right behind it. A surface is drawn to the side that has its effect in the vehicle file.
CAS_SIM_EXPORT std::vector<DrawnSurface> drawn_surfaces(std::span<const Shape> visuals,
                                                        const base::AeroParams& aero);

/// The shapes of a world that do not move; of a terrain its picture, by the name "terrain".
CAS_SIM_EXPORT std::vector<Shape> drawn_world(const WorldModel& world);

/// A mesh as pages take it. Little-endian: counts of vertices and of triangles (uint32), vertices
/// (float32 x, y, z, m), triangles (uint32 indices).
CAS_SIM_EXPORT std::string mesh_bytes(const TriangleMesh& mesh);

}  // namespace cas::sim

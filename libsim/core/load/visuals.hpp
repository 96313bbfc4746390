// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/model_loader.hpp"

namespace cas::sim {

/// A vehicle as its makers draw it, where there is a mesh among its visuals; poses in B. Empty
/// where none can be read, or they have more triangles than that: then a stand-in is drawn.
/// @param warnings  takes a sentence with link and file for each mesh that cannot be read
CAS_SIM_EXPORT std::vector<Shape> load_visuals(const VehicleModel& model,
                                               std::size_t most_triangles,
                                               std::vector<std::string>& warnings);

/// A mesh as pages take it. Little-endian: counts of vertices and of triangles (uint32), vertices
/// (float32 x, y, z, m), triangles (uint32 indices).
CAS_SIM_EXPORT std::string mesh_bytes(const TriangleMesh& mesh);

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/load/mesh_options.hpp"

namespace cas::sim {

/// The faces of a Wavefront OBJ file, cut into triangles; they are taken as convex. Lines, points,
/// normals and materials are left out without a word, other elements (curves and surfaces), faces
/// of fewer than three corners and vertices that nothing names with a warning.
/// @throws base::ConfigError "FILE:LINE: ..."
TriangleMesh parse_obj(std::string_view bytes, const std::string& file, const MeshOptions& options);

}  // namespace cas::sim

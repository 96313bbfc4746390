// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/load/mesh_options.hpp"

namespace cas::sim {

/// The triangles of a COLLADA file (.dae) in metres: every geometry that its scene names, placed by
/// the nodes above it; triangles, strips, fans, polylists and polygons, which are taken as convex.
/// The unit is applied, <up_axis> by `options`. Materials and normals are left out without a word;
/// other geometry that is not read (skins, splines, holes) with a warning.
/// @throws base::ConfigError "FILE:LINE: ..." for a number, reference or transformation that cannot
///     be read, and for a file that grows beyond kMostTriangles or a million elements of nodes
TriangleMesh parse_collada(std::string_view text, const std::string& file,
                           const MeshOptions& options);

}  // namespace cas::sim

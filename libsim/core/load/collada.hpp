// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "libsim/core/body/shape.hpp"

namespace cas::sim {

/// The triangles of a COLLADA file (.dae) in metres with z up: every geometry that its scene names,
/// placed by the nodes above it; triangles, polylists and polygons, which are taken as convex.
/// Unit and up axis are applied. Materials, normals, skins and animations are left out.
/// @throws base::ConfigError that names `file`
TriangleMesh parse_collada(std::string_view text, const std::string& file);

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/load/mesh_options.hpp"

namespace cas::sim {

/// The triangles of an STL file, binary or text in letters of either case. Bytes behind the
/// triangles that a binary header promises are named in a warning, and a word in a facet of text
/// that has no place there.
/// @throws base::ConfigError "FILE: ...", of text "FILE:LINE: ...", also for a file that is cut
TriangleMesh parse_stl(std::string_view bytes, const std::string& file, const MeshOptions& options);

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/mesh_options.hpp"

namespace cas::sim {

/// A sentence for a file whose name is none of a mesh that is read; nullopt for one that is.
CAS_SIM_EXPORT std::optional<std::string> mesh_kind_refusal(const std::filesystem::path& file);

/// Reads an STL (binary or text), Wavefront OBJ or COLLADA (.dae) file; `scale` is applied per
/// axis and may mirror. Materials, normals and colours are left out.
/// @throws base::ConfigError naming the file, and of text the line, for any other or damaged file
CAS_SIM_EXPORT TriangleMesh load_mesh(const std::filesystem::path& file,
                                      const Eigen::Vector3d& scale = Eigen::Vector3d::Ones(),
                                      const MeshOptions& options = {});

/// The same from what such a file holds, in its own units. @param file  whose name tells the format
CAS_SIM_EXPORT TriangleMesh parse_mesh(std::string_view bytes, const std::filesystem::path& file,
                                       const MeshOptions& options);

/// The bounding box of the triangles along the mesh's own axes, and the box's centre. A vertex that
/// no triangle has, as of a line, does not count.
CAS_SIM_EXPORT Box bounding_box(const TriangleMesh& mesh, Eigen::Vector3d& centre);

}  // namespace cas::sim

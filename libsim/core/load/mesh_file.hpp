// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Reads an STL (binary or text), Wavefront OBJ or COLLADA (.dae) file; `scale` is applied per
/// axis. Materials, normals and colours are left out. @throws base::ConfigError for any other or a
/// damaged file
CAS_SIM_EXPORT TriangleMesh load_mesh(const std::filesystem::path& file,
                                      const Eigen::Vector3d& scale = Eigen::Vector3d::Ones());

/// The mesh's bounding box along its own axes, and the box's centre.
CAS_SIM_EXPORT Box bounding_box(const TriangleMesh& mesh, Eigen::Vector3d& centre);

}  // namespace cas::sim

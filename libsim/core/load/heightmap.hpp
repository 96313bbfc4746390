// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"

namespace cas::sim {

/// Most pixels along an edge of a heightmap: two million triangles.
inline constexpr unsigned kLargestHeightmap = 1025;

/// Ground from a greyscale PNG of 8 or 16 bits; of a coloured one the red channel counts.
///
/// A pixel is a vertex: the image's first row lies at +y, its first column at -x, black at z = 0
/// and the brightest pixel at the height of `size_m`, as Gazebo has it. Two triangles fill the cell
/// between four pixels.
/// @param size_m    east, north and up, m
/// @param offset_m  of the middle of the ground, in the shape's frame
/// @throws base::ConfigError when the file is no such image, is cut, or has fewer than 2 or more
///         than kLargestHeightmap pixels along an edge
CAS_SIM_EXPORT TriangleMesh load_heightmap(const std::filesystem::path& file,
                                           const Eigen::Vector3d& size_m,
                                           const Eigen::Vector3d& offset_m);

/// The same from what such a file holds. @param file  its name, for errors
CAS_SIM_EXPORT TriangleMesh parse_heightmap(std::string_view bytes, const std::string& file,
                                            const Eigen::Vector3d& size_m,
                                            const Eigen::Vector3d& offset_m);

}  // namespace cas::sim

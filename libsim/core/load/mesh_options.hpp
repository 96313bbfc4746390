// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace cas::sim {

/// What a COLLADA file's <up_axis> does.
enum class UpAxis {
  kIgnored,  ///< nothing: the file's numbers are x, y, z, as Gazebo and RViz take them
  kApplied,  ///< the mesh is turned so that this axis points up, as COLLADA has it
};

/// How a mesh is read.
struct MeshOptions {
  UpAxis up_axis = UpAxis::kIgnored;
  /// Takes a sentence "FILE:LINE: ..." for each part that is not read; nullptr: they are dropped.
  std::vector<std::string>* warnings = nullptr;

  void warn(std::string sentence) const {
    if (warnings != nullptr) warnings->push_back(std::move(sentence));
  }
};

/// Most triangles of a mesh, and of all meshes of a world, each counted once however often it
/// occurs. They take up to a gigabyte.
inline constexpr std::size_t kMostTriangles = 5'000'000;

}  // namespace cas::sim

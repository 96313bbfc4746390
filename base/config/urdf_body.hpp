// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// A link of a URDF as it stands in the root link's frame.
struct UrdfLink {
  std::string name;
  int line = 0;                           ///< of its joint, or of the root link
  Eigen::Vector3d position_R_m{0, 0, 0};  ///< origin of its joint
  std::optional<Eigen::Vector3d> axis_R;  ///< of the continuous joint that it turns about, unit
};

/// What a URDF says of the whole vehicle, its rotors at rest.
struct CAS_BASE_EXPORT UrdfBody {
  std::filesystem::path file;
  double mass_kg = 0;     ///< 0 where no link has any
  int inertial_line = 0;  ///< of the first <inertial>
  Eigen::Vector3d cog_R_m{0, 0, 0};
  Eigen::Matrix3d inertia_B_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of gravity
  std::vector<UrdfLink> links;                                ///< from the root outwards

  /// The link of that name, or nothing.
  const UrdfLink* find(std::string_view name) const;
  /// From the centre of gravity, in axes that are the root link's: forward, left, up.
  Eigen::Vector3d position_B_m(const UrdfLink& link) const { return link.position_R_m - cog_R_m; }
};

/// Reads mass, inertia and places. Links are combined by the parallel-axis theorem; a link whose
/// inertia no body can have counts as a point mass, joints other than continuous ones as fixed.
/// @return nothing for a file that is missing or no URDF: who loads the shapes says what is wrong
CAS_BASE_EXPORT std::optional<UrdfBody> read_urdf_body(const std::filesystem::path& file);

/// True when a body can have this inertia: symmetric, positive definite, and no principal moment
/// larger than the sum of the others.
CAS_BASE_EXPORT bool is_physical_inertia(const Eigen::Matrix3d& inertia);

}  // namespace cas::base

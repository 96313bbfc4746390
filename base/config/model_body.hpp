// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// A link of a model in the model's frame R: that of a URDF's root link, or of an SDF's <model>.
struct ModelLink {
  std::string name;
  int line = 0;                           ///< of its joint, or of the root link
  Eigen::Vector3d position_R_m{0, 0, 0};  ///< origin of its joint
  std::optional<Eigen::Vector3d> axis_R;  ///< of the joint that it turns about without end, unit
};

/// The whole vehicle according to a model file, with its rotors at rest.
struct CAS_BASE_EXPORT ModelBody {
  std::filesystem::path file;
  double mass_kg = 0;     ///< 0 where no link has any
  int inertial_line = 0;  ///< of the first <inertial>
  Eigen::Vector3d cog_R_m{0, 0, 0};
  Eigen::Matrix3d inertia_B_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of gravity
  std::vector<ModelLink> links;                               ///< a URDF's from the root outwards

  /// The link of that name, or nothing.
  const ModelLink* find(std::string_view name) const;
  /// From the centre of gravity, in axes that are R's: forward, left, up.
  Eigen::Vector3d position_B_m(const ModelLink& link) const { return link.position_R_m - cog_R_m; }
};

/// Mass and inertia of a link, as its <inertial> has them.
struct Inertial {
  double mass_kg = 0;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< of the centre of gravity in the link
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about it, in its axes
  int line = 0;
};

/// Combines links by the parallel-axis theorem. A link whose inertia no body can have counts as a
/// point mass.
class BodySum {
 public:
  /// @param X_RL  of the link in R
  void add(const Inertial& inertial, const Eigen::Isometry3d& X_RL);
  /// Writes mass, centre of gravity, inertia and line.
  void finish(ModelBody& body) const;

 private:
  double mass_kg_ = 0;
  int first_line_ = 0;
  Eigen::Vector3d moment_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_ = Eigen::Matrix3d::Zero();  // about the origin of R
};

/// Largest file of a vehicle's model that is read.
inline constexpr std::size_t kMaxModelBytes = std::size_t{16} << 20U;

/// Reads mass, inertia and places from a URDF or SDF file, whichever it is.
/// @return nullopt for a file that is missing or neither: the loader of the shapes reports the
///     error
/// @throws ConfigError for an SDF file that describes no single vehicle, and for a file that is not
///     regular or too large
CAS_BASE_EXPORT std::optional<ModelBody> read_model_body(const std::filesystem::path& file);

/// True when a body can have this inertia: symmetric, positive definite, and no principal moment
/// larger than the sum of the others.
CAS_BASE_EXPORT bool is_physical_inertia(const Eigen::Matrix3d& inertia);

}  // namespace cas::base

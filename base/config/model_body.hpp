// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/model_parts.hpp"
#include "base/export.hpp"

namespace cas::base {

/// A link of a model in the model's frame R: that of a URDF's root link, or of an SDF's <model>.
struct ModelLink {
  std::string name{};                       ///< of an included model's link "gps0::link"
  std::string joint{};                      ///< that carries it; empty: none
  std::string place{};                      ///< FILE:LINE of that joint, else of the link
  double mass_kg = 0;                       ///< its own
  Eigen::Vector3d position_R_m{0, 0, 0};    ///< origin of its joint
  std::optional<Eigen::Vector3d> axis_R{};  ///< of the joint that it turns about without end, unit
};

/// A <collision> or <visual> of a link.
struct ModelShape {
  enum class Form { kBox, kSphere, kCylinder, kMesh, kOther };
  std::string link{};
  std::string name{};   ///< its own; empty: none
  std::string place{};  ///< FILE:LINE of its form
  std::string word{};   ///< the form's element: "box"
  Form form = Form::kOther;
  bool visual = false;  ///< else it collides
  bool turns = false;   ///< a rotor's
  /// Edges of a box, (r, r, r) of a sphere, (r, r, length) of a cylinder: m; a mesh's scale.
  Eigen::Vector3d size{0, 0, 0};
  std::string uri{};                                       ///< of a mesh
  std::filesystem::path file{};                            ///< that names the mesh
  Eigen::Isometry3d X_RS = Eigen::Isometry3d::Identity();  ///< in R
};

/// A motor plugin of the model: Gazebo's coefficients of a rotor, by the vehicle file's keys.
struct ModelMotor {
  std::string place{};
  std::string link{};   ///< empty: none is named
  std::string joint{};  ///< empty: none is named
  std::optional<int> spin{};
  bool reversible = false;
  std::map<std::string, double, std::less<>> keys{};
};

/// The whole vehicle according to a model file, with its rotors at rest.
struct CAS_BASE_EXPORT ModelBody {
  std::filesystem::path file{};
  std::string name{};
  double mass_kg = 0;            ///< 0 where no link has any
  std::string inertial_place{};  ///< FILE:LINE of the first <inertial>
  Eigen::Vector3d cog_R_m{0, 0, 0};
  Eigen::Matrix3d inertia_B_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre of gravity
  std::vector<ModelLink> links;                               ///< a URDF's from the root outwards
  std::vector<ModelShape> shapes;
  std::vector<ModelMotor> motors;
  std::vector<std::string> warnings;  ///< one sentence for each repair or omission

  /// The link of that name, else the only one of that name in an included model, or nothing.
  const ModelLink* find(std::string_view link_name) const;
  /// The plugin that drives a link, or nothing.
  const ModelMotor* motor_of(const ModelLink& link) const;
  /// From the centre of gravity, in axes that are R's: forward, left, up.
  Eigen::Vector3d position_B_m(const ModelLink& link) const { return link.position_R_m - cog_R_m; }
};

/// Largest file of a vehicle's model that is read, and most links of a vehicle.
inline constexpr std::size_t kMaxModelBytes = std::size_t{4} << 20U;
inline constexpr std::size_t kMaxModelLinks = 1000;

/// Reads a URDF or SDF file, whichever it is.
///
/// Links are combined by the parallel-axis theorem. A link whose inertia no body of its mass can
/// have is named in `warnings` and counts as a point mass, and so are joints that move and are no
/// rotors: they count as fixed.
/// @return nullopt for a file that is missing
/// @throws ConfigError "FILE:LINE: ..." for one that is no model of a vehicle, and for a name in
///     `parts` that the model does not have
CAS_BASE_EXPORT std::optional<ModelBody> read_model_body(const std::filesystem::path& file,
                                                         const ModelParts& parts = {});

/// The same of the text of a file. @param file  for errors, and to find included models
CAS_BASE_EXPORT ModelBody parse_model_body(std::string_view text, const std::filesystem::path& file,
                                           const ModelParts& parts = {});

/// True when a body can have this inertia: symmetric, positive definite, and no principal moment
/// larger than the sum of the others.
CAS_BASE_EXPORT bool is_physical_inertia(const Eigen::Matrix3d& inertia);

}  // namespace cas::base

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>

#include "base/config/model_body.hpp"
#include "base/config/model_form.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Mass and inertia of a link, as its <inertial> has them.
struct Inertial {
  double mass_kg = 0;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< of the centre of gravity in the link
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about it, in its axes
  const XmlElement* element = nullptr;
};

/// The tensor of the moments "ixx" to "izz". Each is read before the matrix is filled: Eigen aborts
/// where an error breaks off the filling.
template <class Moment>
Eigen::Matrix3d inertia_tensor(Moment&& moment) {
  const double ixx = moment("ixx");
  const double iyy = moment("iyy");
  const double izz = moment("izz");
  const double ixy = moment("ixy");
  const double ixz = moment("ixz");
  const double iyz = moment("iyz");
  return (Eigen::Matrix3d() << ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz).finished();
}

/// A link's joint.
struct LinkJoint {
  const XmlElement* element = nullptr;  ///< nullptr: the link has none
  std::string name{};
  bool moves = false;                       ///< in the file
  std::optional<Eigen::Vector3d> axis_R{};  ///< of one that turns without end
};

/// Puts the links of a model together, by the same rules for both formats.
class ModelBuilder {
 public:
  ModelBuilder(const std::filesystem::path& file, const ModelParts& parts);

  /// Whether the vehicle file leaves out the part of that name.
  bool leaves_out(std::string_view name);
  /// Whether it says of the part of that name that nothing in it is a rotor.
  bool fixes(std::string_view name);

  /// Adds a link and its mass. A link of the same name, and one too many, throws ConfigError.
  /// @param position_R_m  of its joint's origin
  /// @return whether its shapes count, and as turning: nullopt for a link that is left out
  std::optional<bool> add(const XmlElement& element, const std::string& name,
                          const Eigen::Isometry3d& X_RL, const LinkJoint& joint,
                          const Eigen::Vector3d& position_R_m,
                          const std::optional<Inertial>& inertial);
  /// Adds a <collision> or <visual> of a link that add() has a value for. A visual that cannot be
  /// read is left out with a warning: the flight does not need it.
  /// @param X_RS  gives its pose
  void add_shape(const XmlElement& part, FormValues values, const std::filesystem::path& file,
                 bool turns, const std::function<Eigen::Isometry3d()>& X_RS);
  void add(ModelMotor motor) { body_.motors.push_back(std::move(motor)); }
  void warn(const XmlElement& at, const std::string& sentence);
  /// Warns of angles beyond a full turn: they may be in degrees.
  /// @param numbers  text of them; the reader of the element refuses what is no number
  /// @param first  of the angles among them
  void warn_of_degrees(const XmlElement& at, std::string_view numbers, std::size_t first);

  /// The sum of all. @throws ConfigError for a name in `parts` that no part of the model has
  ModelBody finish(std::string name);

 private:
  bool is_used(std::string_view name, PartUse use);
  void take_shape(const XmlElement& part, FormValues values, ModelShape shape,
                  const std::function<Eigen::Isometry3d()>& X_RS);
  void add_mass(const std::string& link, const Inertial& inertial, const Eigen::Isometry3d& X_RL);

  const ModelParts& parts_;
  std::set<std::string, std::less<>> met_;  // of parts_
  std::set<std::string, std::less<>> names_;
  ModelBody body_;
  Eigen::Vector3d moment_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_ = Eigen::Matrix3d::Zero();  // about the origin of R
};

/// Rotation by roll, pitch and yaw about fixed axes, in both formats, rad.
Eigen::Matrix3d rotation_rpy(double roll, double pitch, double yaw);

}  // namespace cas::base

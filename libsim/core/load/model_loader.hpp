// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "base/config/model_parts.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "libsim/core/body/shape.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/mesh_options.hpp"

namespace cas::sim {

/// A rotor as the model places it: the child of a continuous joint.
struct ModelRotor {
  std::string joint;
  Eigen::Vector3d position_B_m;  ///< joint origin from the centre of gravity
  Eigen::Vector3d axis_B;        ///< unit
};

/// A mesh that was found, but not read.
struct MeshFile {
  std::filesystem::path path;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

/// A <visual> of the vehicle, for pictures.
struct Visual {
  std::string link;
  std::string name;  ///< its own; empty: none
  std::variant<Geometry, MeshFile> form;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/// A vehicle as one rigid body: B has its origin in the centre of gravity and the axes of a URDF's
/// root link or of an SDF's model, which are forward, left, up.
struct VehicleModel {
  std::string name;
  MassProperties mass;
  Eigen::Vector3d cog_in_root_m = Eigen::Vector3d::Zero();
  std::vector<Shape> shapes;          ///< poses in B; meshes as their bounding boxes
  std::vector<Visual> visuals;        ///< poses in B; without those of rotors, which turn
  UpAxis up_axis = UpAxis::kIgnored;  ///< of its COLLADA meshes
  std::vector<ModelRotor> rotors;
  std::vector<std::string> warnings;  ///< one sentence for each repair or omission
};

/// Reads the model of a vehicle, an SDF or URDF file (base::read_model_body()), also one that
/// SolidWorks exported (several links, package:// meshes). Rotors count with their mass and inertia
/// at rest.
/// @param parts    as the vehicle file has them
/// @param up_axis  of COLLADA meshes
/// @throws base::ConfigError naming file and element
CAS_SIM_EXPORT VehicleModel load_vehicle_model(const std::filesystem::path& file,
                                               const base::ModelParts& parts,
                                               UpAxis up_axis = UpAxis::kIgnored);
/// The same of a vehicle without `parts`.
CAS_SIM_EXPORT VehicleModel load_vehicle_model(const std::filesystem::path& file);

}  // namespace cas::sim

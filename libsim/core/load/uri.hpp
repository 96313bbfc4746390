// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "libsim/core/export.hpp"

namespace cas::sim {

/// The file that a URDF's `package://NAME/rest`, `file://` or plain URI means. A package is looked
/// for among the folders above `folder` (as SolidWorks exports: NAME/urdf, NAME/meshes) and in
/// ROS_PACKAGE_PATH; a plain path is relative to `folder`.
CAS_SIM_EXPORT std::optional<std::filesystem::path> find_package_file(
    const std::string& uri, const std::filesystem::path& folder);

/// The file or folder that an SDF's `model://NAME/rest`, `file://` or plain URI means: relative to
/// `folder`, then in each of `model_path`, then in GAZEBO_MODEL_PATH and GZ_SIM_RESOURCE_PATH.
CAS_SIM_EXPORT std::optional<std::filesystem::path> find_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The finders of base/config/model_uri.hpp under the names that this library exports.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libsim/core/export.hpp"

namespace cas::sim {

/// The file that a URDF's `package://NAME/rest`, `file://` or plain URI means. A package is looked
/// for among the folders above `folder` (as SolidWorks exports: NAME/urdf, NAME/meshes) and in
/// ROS_PACKAGE_PATH; a plain path is relative to `folder`.
CAS_SIM_EXPORT std::optional<std::filesystem::path> find_package_file(
    const std::string& uri, const std::filesystem::path& folder);

/// Where the file or folder that an SDF's `model://NAME/rest`, `file://` or plain URI means may be,
/// best first: relative to `folder`, in each of `model_path`, in GAZEBO_MODEL_PATH,
/// GZ_SIM_RESOURCE_PATH and SDF_PATH. Of a model of Gazebo's Fuel (`https://`) the copy that
/// `gz fuel download` has made, then a model of its name in the same folders; nothing is
/// downloaded.
CAS_SIM_EXPORT std::vector<std::filesystem::path> places_of_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

/// The first of places_of_model_file() that exists.
CAS_SIM_EXPORT std::optional<std::filesystem::path> find_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

}  // namespace cas::sim

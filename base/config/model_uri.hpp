// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// The file that a URDF's `package://NAME/rest`, `file://` or plain URI means. A package is looked
/// for among the folders above `folder` (as SolidWorks exports: NAME/urdf, NAME/meshes) and in
/// ROS_PACKAGE_PATH; a plain path is relative to `folder`.
CAS_BASE_EXPORT std::optional<std::filesystem::path> find_package_file(
    const std::string& uri, const std::filesystem::path& folder);

/// Where the file or folder that an SDF's `model://NAME/rest`, `file://` or plain URI means may be,
/// best first: relative to `folder`, in each of `model_path`, in GAZEBO_MODEL_PATH,
/// GZ_SIM_RESOURCE_PATH and SDF_PATH. Of a model of Gazebo's Fuel (`https://`) the copy that
/// `gz fuel download` has made, then a model of its name in the same folders; nothing is
/// downloaded.
CAS_BASE_EXPORT std::vector<std::filesystem::path> places_of_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

/// The first of places_of_model_file() that exists.
CAS_BASE_EXPORT std::optional<std::filesystem::path> find_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

/// The folders above a model's own, in which a model:// URI finds the model itself and those beside
/// it: of models/iris/model.sdf models/ and the folder around that.
CAS_BASE_EXPORT std::vector<std::filesystem::path> folders_above(const std::filesystem::path& file);

}  // namespace cas::base

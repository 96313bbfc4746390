// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/export.hpp"

namespace cas::base {

/// Where the file or folder that a URI of an SDF, URDF or mesh means may be, best first.
/// `model://NAME/rest`, `package://NAME/rest`, `file://` and a plain path are looked for relative
/// to `folder`, in each of `model_path`, in GAZEBO_MODEL_PATH, GZ_SIM_RESOURCE_PATH, SDF_PATH and
/// ROS_PACKAGE_PATH, then in the folders above `folder`: a model that names its own files lies in
/// one of them. Of `package://` the folders above come first, also without NAME, which an unpacked
/// export may have lost. Of a model of Gazebo's Fuel (`https://`) the copy that `gz fuel download`
/// has made, then a model of its name; nothing is downloaded.
CAS_BASE_EXPORT std::vector<std::filesystem::path> places_of_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

/// The first of places_of_model_file() that exists.
CAS_BASE_EXPORT std::optional<std::filesystem::path> find_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path);

/// The places of places_of_model_file() in a sentence, each once: "/w/oak, /models/oak".
CAS_BASE_EXPORT std::string searched_places(const std::string& uri,
                                            const std::filesystem::path& folder,
                                            std::span<const std::filesystem::path> model_path);

}  // namespace cas::base

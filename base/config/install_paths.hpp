// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/export.hpp"

/// Where the shipped files are, in the build tree and in an installation.
namespace cas::base {

/// Folders with shipped configuration, best first: each of CAS_CONFIG_PATH (colon-separated), then
/// the one that belongs to the running program or this library. Only folders that exist.
CAS_BASE_EXPORT std::vector<std::filesystem::path> config_dirs();

/// Folders with plugins, best first: each of CAS_PLUGIN_PATH, then the one that belongs to the
/// running program or this library. Only folders that exist.
CAS_BASE_EXPORT std::vector<std::filesystem::path> plugin_dirs();

/// Folder of the built page (index.html, replay.html and their files): CAS_WEB_PATH, else the one
/// that belongs to the running program or this library. nullopt if the page was not built.
CAS_BASE_EXPORT std::optional<std::filesystem::path> web_dir();

/// A file given by the user: unchanged if it exists (absolute or from the working folder), else
/// below one of config_dirs(), "vehicles/iris_paper.yaml". @throws ConfigError when it is nowhere
CAS_BASE_EXPORT std::filesystem::path find_config(const std::filesystem::path& name);

/// A file that belongs to CAS itself, below one of config_dirs(): never one of the working folder,
/// where a file of this name is somebody's own. @throws ConfigError when it is nowhere
CAS_BASE_EXPORT std::filesystem::path shipped_config(const std::string& name);

/// The file that the value of a key names: relative to the file that has the key, else below one of
/// config_dirs(). In the latter case leading "../" are dropped, so that a copy of a shipped file
/// ("../vehicles/iris_paper.yaml") still finds the files that it names. @throws ConfigError
/// "FILE:LINE: key: ..." with the folders searched when it is nowhere
CAS_BASE_EXPORT std::filesystem::path find_config(const ConfigNode& node);

}  // namespace cas::base

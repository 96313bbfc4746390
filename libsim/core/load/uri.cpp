// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/uri.hpp"

#include <cstdlib>
#include <sstream>
#include <string_view>
#include <vector>

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> path_list(const char* variable) {
  std::vector<fs::path> folders;
  const char* const value = std::getenv(variable);
  std::istringstream words(value == nullptr ? "" : value);
  for (std::string word; std::getline(words, word, ':');) {
    if (!word.empty()) folders.emplace_back(word);
  }
  return folders;
}

std::optional<fs::path> existing(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  return path.lexically_normal();
}

/// The rest of `uri` behind `scheme`, or nothing.
std::optional<std::string> behind(const std::string& uri, std::string_view scheme) {
  if (uri.rfind(scheme, 0) != 0) return std::nullopt;
  return uri.substr(scheme.size());
}

std::optional<fs::path> find_in_package(const fs::path& rest, const fs::path& folder) {
  const fs::path name = *rest.begin();
  for (fs::path up = fs::absolute(folder).lexically_normal(); up.has_relative_path();
       up = up.parent_path()) {
    if (up.filename() == name) {
      if (auto found = existing(up.parent_path() / rest)) return found;
    }
    if (auto found = existing(up / rest)) return found;
    // An unpacked export may have lost its folder's name: meshes/ beside urdf/ is enough.
    if (auto found = existing(up / rest.lexically_relative(name))) return found;
  }
  for (const fs::path& root : path_list("ROS_PACKAGE_PATH")) {
    if (auto found = existing(root / rest)) return found;
  }
  return std::nullopt;
}

}  // namespace

std::optional<fs::path> find_package_file(const std::string& uri, const fs::path& folder) {
  if (const auto rest = behind(uri, "package://")) {
    return rest->empty() ? std::nullopt : find_in_package(*rest, folder);
  }
  if (const auto rest = behind(uri, "file://")) return existing(*rest);
  return existing(folder / uri);
}

std::optional<fs::path> find_model_file(const std::string& uri, const fs::path& folder,
                                        std::span<const fs::path> model_path) {
  if (const auto rest = behind(uri, "file://")) {
    if (auto found = existing(folder / *rest)) return found;
  }
  const auto model = behind(uri, "model://");
  const std::string name = model ? *model : uri;
  if (auto found = existing(folder / name)) return found;
  for (const fs::path& root : model_path) {
    if (auto found = existing(root / name)) return found;
  }
  for (const char* variable : {"GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "SDF_PATH"}) {
    for (const fs::path& root : path_list(variable)) {
      if (auto found = existing(root / name)) return found;
    }
  }
  return std::nullopt;
}

}  // namespace cas::sim

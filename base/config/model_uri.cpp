// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_uri.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"

namespace cas::base {

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

/// The folders from `folder` up to the last below the root. An empty one is the working folder.
std::vector<fs::path> folders_above(const fs::path& folder) {
  std::vector<fs::path> folders;
  const fs::path named = folder.empty() ? fs::path(".") : folder;
  for (fs::path up = fs::absolute(named).lexically_normal(); up.has_relative_path();
       up = up.parent_path()) {
    if (up.has_filename()) folders.push_back(up);  // else it ends in a slash
  }
  return folders;
}

/// Places of `package://NAME/rest`: NAME is among the folders above, as SolidWorks exports
/// (NAME/urdf, NAME/meshes), or lost: meshes/ beside urdf/ is enough.
void add_package(const fs::path& rest, const fs::path& folder, std::vector<fs::path>& places) {
  if (rest.empty()) return;
  const fs::path name = *rest.begin();
  for (const fs::path& up : folders_above(folder)) {
    if (up.filename() == name) places.push_back(up.parent_path() / rest);
    places.push_back(up / rest);
    places.push_back(up / rest.lexically_relative(name));
  }
}

/// The parts of "server/1.0/Owner/models/Name/rest", without the version of the interface.
std::vector<std::string> fuel_parts(const std::string& url) {
  std::vector<std::string> parts;
  std::istringstream words(url);
  for (std::string word; std::getline(words, word, '/');) {
    if (!word.empty()) parts.push_back(word);
  }
  if (parts.size() > 1 && std::isdigit(static_cast<unsigned char>(parts[1].front())) != 0) {
    parts.erase(parts.begin() + 1);
  }
  return parts;
}

constexpr std::size_t kFuelName = 3;  // server, owner, "models", name

/// Name of the model that an address of Gazebo's Fuel means, with a file in it if there is one.
std::string fuel_name(const std::string& url) {
  const std::vector<std::string> parts = fuel_parts(url);
  if (parts.size() <= kFuelName) return url;
  std::string name = parts[kFuelName];
  // Behind the name come a version ("2", "tip"), "files" and the file's path.
  const auto files = std::find(parts.begin(), parts.end(), "files");
  for (auto part = files; part != parts.end(); ++part) {
    if (part != files) name += "/" + *part;
  }
  return name;
}

/// Where `gz fuel download` puts it: ~/.gz/fuel/SERVER/owner/models/name/VERSION, newest first.
void add_fuel_cache(const std::string& url, std::vector<fs::path>& places) {
  const std::vector<std::string> parts = fuel_parts(url);
  const char* const home = std::getenv("HOME");
  if (home == nullptr || parts.size() <= kFuelName) return;
  fs::path folder = fs::path(home) / ".gz/fuel";
  for (std::size_t i = 0; i <= kFuelName; ++i) {
    std::string part = parts[i];
    std::transform(part.begin(), part.end(), part.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    folder /= part;
  }
  int newest = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    newest = std::max(newest, std::atoi(entry.path().filename().c_str()));
  }
  const std::string rest = fuel_name(url).substr(parts[kFuelName].size());
  places.emplace_back((newest > 0 ? folder / std::to_string(newest) : folder).string() + rest);
}

}  // namespace

std::vector<fs::path> places_of_model_file(const std::string& uri, const fs::path& folder,
                                           std::span<const fs::path> model_path) {
  std::vector<fs::path> places;
  const auto url = behind(uri, "https://");
  const auto package = behind(uri, "package://");
  std::string name = url       ? fuel_name(*url)
                     : package ? *package
                               : behind(uri, "model://").value_or(uri);
  if (behind(uri, "model://")) name.erase(0, name.find_first_not_of('/'));  // model:///NAME
  if (const auto rest = behind(uri, "file://")) {
    places.push_back(folder / *rest);
    name = *rest;
  }
  if (url) add_fuel_cache(*url, places);
  if (package) add_package(name, folder, places);
  if (!url) places.push_back(folder / name);
  for (const fs::path& root : model_path) places.push_back(root / name);
  for (const char* variable :
       {"GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "SDF_PATH", "ROS_PACKAGE_PATH"}) {
    for (const fs::path& root : path_list(variable)) places.push_back(root / name);
  }
  const bool is_bare = uri.find("://") == uri.npos && fs::path(uri).is_relative();
  if (behind(uri, "model://") || is_bare) {
    for (const fs::path& up : folders_above(folder)) places.push_back(up / name);
  }
  return places;
}

std::optional<fs::path> find_model_file(const std::string& uri, const fs::path& folder,
                                        std::span<const fs::path> model_path) {
  for (const fs::path& place : places_of_model_file(uri, folder, model_path)) {
    if (auto found = existing(place)) return found;
  }
  return std::nullopt;
}

std::string searched_places(const std::string& uri, const fs::path& folder,
                            std::span<const fs::path> model_path) {
  std::vector<std::string> places;
  for (const fs::path& place : places_of_model_file(uri, folder, model_path)) {
    std::string name = fs::absolute(place).lexically_normal().string();
    if (std::ranges::find(places, name) == places.end()) places.push_back(std::move(name));
  }
  return joined(places, ", ");
}

}  // namespace cas::base

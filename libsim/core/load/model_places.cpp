// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_uri.hpp"
#include "libsim/core/load/uri.hpp"

namespace cas::sim {

std::optional<std::filesystem::path> find_package_file(const std::string& uri,
                                                       const std::filesystem::path& folder) {
  return base::find_package_file(uri, folder);
}

std::vector<std::filesystem::path> places_of_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path) {
  return base::places_of_model_file(uri, folder, model_path);
}

std::optional<std::filesystem::path> find_model_file(
    const std::string& uri, const std::filesystem::path& folder,
    std::span<const std::filesystem::path> model_path) {
  return base::find_model_file(uri, folder, model_path);
}

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "base/config/config.hpp"

namespace YAML {
class Node;
}

namespace cas::hils {

/// A copy of a map; an empty map for any other node.
YAML::Node copy(const base::ConfigNode& node);
/// YAML text with a line break at its end.
std::string to_text(const YAML::Node& node);
/// The path without relative parts and, as far as it exists, without symlinks.
std::string full_path(const std::filesystem::path& path);

}  // namespace cas::hils

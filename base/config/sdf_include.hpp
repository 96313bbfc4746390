// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/config/xml_tree.hpp"

namespace cas::base {

/// An included file.
struct SdfFile {
  XmlElement root;  ///< <sdf>
  std::filesystem::path path;
};

/// Reads the file that an <include> means: the SDF itself, or a folder with its model.config.
/// @param file  that has the <include>
/// @throws ConfigError naming the <include>, and the places searched where it is missing
SdfFile read_sdf_include(const XmlElement& include, const std::filesystem::path& file);

}  // namespace cas::base

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libsim/core/load/sdf_description.hpp"

namespace cas::sim {

/// How large a text in SDF is.
struct SdfExtent {
  using Counts = std::map<std::string, std::size_t>;  ///< by name of the element

  Counts elements;                    ///< those that are in no other model's model
  Counts nested;                      ///< models in models, and what is in them
  std::size_t deepest = 0;            ///< elements in each other
  std::vector<std::string> includes;  ///< what the <uri> of each <include> names
};

/// Counts without building a tree, which may be what a hostile text is after. It takes whatever
/// libsdformat takes: a text need not be well-formed.
SdfExtent sdf_extent(std::string_view text);

/// Finds the file or folder that a URI of a world means.
using FindFile = std::function<std::optional<std::filesystem::path>(const std::string& uri)>;

/// Looks at a world's file and all files that it includes, each time that it includes them, before
/// libsdformat reads them: it takes megabytes for a model, and goes into itself for each element
/// that lies in another. With the description that is returned it takes a twentieth for each model
/// of the world's file; included and nested models it gives the whole one, and no other.
/// @return what SDF may hold, as far as the world's file makes use of it
/// @throws base::ConfigError for a world that would take more than 4 GB, for elements more than 200
///     deep, for a model that includes itself, and for a file that cannot be read
SdfDescription require_readable_extent(const std::filesystem::path& world, const FindFile& find);

}  // namespace cas::sim

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
#include "libsim/core/load/sdf_missing.hpp"

namespace cas::sim {

/// What an element of an <include> says.
struct SdfWord {
  std::string text;
  std::size_t line = 0;  ///< from 1
};

/// How large a text in SDF is.
struct SdfExtent {
  using Counts = std::map<std::string, std::size_t>;  ///< by name of the element

  Counts elements;                ///< those that are in no other model's model
  Counts nested;                  ///< models in models, and what is in them
  std::size_t deepest = 0;        ///< elements in each other
  std::vector<SdfWord> includes;  ///< the <uri> of each <include>
  std::vector<SdfWord> poses;     ///< the <pose> of those that have one
};

/// Counts without building a tree, which may be what a hostile text is after. It takes whatever
/// libsdformat takes: a text need not be well-formed.
SdfExtent sdf_extent(std::string_view text);

/// Finds the file or folder that a URI means in a file of that folder.
using FindFile = std::function<std::optional<std::filesystem::path>(
    const std::string& uri, const std::filesystem::path& folder)>;

/// What a world's file and all files that it includes hold.
struct SdfContents {
  SdfDescription description;  ///< what SDF may hold, as far as the world's file makes use of it
  std::map<std::string, std::filesystem::path> included;  ///< file or folder of each URI
  std::vector<MissingFile> missing;  ///< models that included files miss, not the world's own
};

/// Looks at a world's file and all files that it includes, each time that it includes them, before
/// libsdformat reads them: it takes megabytes for a model, and goes into itself for each element
/// that lies in another. With the description that is returned it takes a twentieth for each model
/// of the world's file; included and nested models it gives the whole one, and no other. A model
/// that an included file misses it would leave out without an error, and a <pose> of an <include>
/// that is no pose it would take for none.
/// @throws base::ConfigError for a world that would take more than 4 GB, for elements more than 200
///     deep, for a model that includes itself, for a URI that means one file here and another
///     there, for such a <pose>, and for a file that cannot be read
SdfContents require_readable_extent(const std::filesystem::path& world, const FindFile& find);

}  // namespace cas::sim

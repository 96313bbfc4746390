// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "base/config/config.hpp"

namespace cas::casd {

/// The files of a topology, each of which overlays those before it:
///
///     casd.yaml                      FILE
///     casd.d/10-radio.yaml           FILE without its extension, .d: its *.yaml by name
///     casd.d/20-station.yaml
///
/// or, if `place` is a folder, its *.yaml. Hidden files and those of other names are ignored.
/// @throws base::ConfigError when one cannot be read or ends in .yml; when somebody who may not
/// write FILE may write the folder beside it or a file there; when a given folder has no such file
std::vector<base::ConfigNode> load_topology_files(const std::filesystem::path& place);

/// All files as one map: a key has the value of the last file that gives it, blocks are merged key
/// by key. Of lists it has those of the last file; see overlaid_list(). Errors name the file of
/// the value.
/// @param files  one at least
base::ConfigNode overlaid(const std::vector<base::ConfigNode>& files);

/// The entries of a list of all files. An entry whose `identity` (the values of these keys) is that
/// of an entry of an earlier file is merged over it and has its place; others follow. Two entries
/// of one file are never merged. @throws base::ConfigError
std::vector<base::ConfigNode> overlaid_list(const std::vector<base::ConfigNode>& files,
                                            std::string_view list,
                                            const std::vector<std::string_view>& identity);

}  // namespace cas::casd

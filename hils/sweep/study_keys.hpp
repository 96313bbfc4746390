// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <tuple>

#include "base/config/config_keys.hpp"
#include "hils/scenario/architecture_word.hpp"

namespace cas::hils {

/// Reads what studies of `hils sweep` and `hils tune` and campaigns have in common: `schema`,
/// `name` (the file's where none is given), `description`, `architecture` and `deadline_s`.
/// @throws base::ConfigError
template <class Study>
void read_study_keys(const base::ConfigNode& root, const std::filesystem::path& file,
                     Study& study) {
  if (root.require<int>("schema") != 1) root.at("schema").fail("this program reads schema 1");
  study.name = file.stem().string();
  base::read_keys(
      root,
      std::tuple{base::key<&Study::name>("name", base::Text{}, ""),
                 base::key<&Study::description>("description", base::Text{}, ""),
                 base::key<&Study::architecture>("architecture", ArchitectureWord{}, ""),
                 base::key<&Study::deadline_s>("deadline_s", base::Range{1, 1e6}, "")},
      study);
}

}  // namespace cas::hils

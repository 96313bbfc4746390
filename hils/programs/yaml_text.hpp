// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/config/config.hpp"
#include "hils/run/run_request.hpp"

namespace YAML {
class Node;
}

/// What the files that a run's programs are started with are written by.
namespace cas::hils {

/// The block as a node of its own; an empty map where there is none.
YAML::Node copy(const base::ConfigNode& node);
/// Puts the keys of `own` over those of `node`.
void overlay(YAML::Node node, const YAML::Node& own);
std::string to_text(const YAML::Node& node);

std::string full_path(const std::filesystem::path& path);
std::string local_port(std::uint16_t port);

/// Whose time the programs run on.
const char* pace_word(const RunRequest& request);

}  // namespace cas::hils

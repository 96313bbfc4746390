// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace cas::hils {

/// Values of the files that a run gave to its simulator and its controllers, by their key paths:
/// "hilsim.vehicles[iris0].plugins[wind].mean_m_s". Empty for a folder without them.
std::map<std::string, std::string> run_settings(const std::filesystem::path& folder);

}  // namespace cas::hils

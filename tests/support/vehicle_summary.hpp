// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace cas::test {

/// The part of a vehicle in the summary.json of a folder of results.
inline nlohmann::json vehicle_summary(const std::filesystem::path& out, std::size_t vehicle = 0) {
  std::ifstream file(out / "summary.json");
  return nlohmann::json::parse(file).at("vehicles").at(vehicle);
}

}  // namespace cas::test

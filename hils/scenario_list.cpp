// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario_list.hpp"

#include <filesystem>
#include <map>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "hils/report/document.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {
namespace {

namespace fs = std::filesystem;

/// The files by what `hils run` takes: "scenarios/hover.yaml". Of one name the one that it finds.
std::map<std::string, fs::path> shipped_scenarios() {
  std::map<std::string, fs::path> files;
  for (const fs::path& folder : base::config_dirs()) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder / "scenarios", none)) {
      if (entry.path().extension() != ".yaml") continue;
      files.emplace("scenarios/" + entry.path().filename().string(), entry.path());
    }
  }
  return files;
}

/// Controller and description.
Row row_of(const fs::path& file) try {
  const Scenario scenario = Scenario::load(file);
  if (!scenario.firmware) return {"emulator", scenario.description};
  const std::string& autopilot = scenario.firmware->autopilot;
  return {autopilot.empty() ? "stock firmware" : autopilot, scenario.description};
} catch (const base::ConfigError& error) {
  return {"-", error.what()};
}

}  // namespace

std::string list_scenarios() {
  Rows rows{{"SCENARIO", "CONTROLLER", "DESCRIPTION"}};
  for (const auto& [name, file] : shipped_scenarios()) {
    Row& row = rows.emplace_back(row_of(file));
    row.insert(row.begin(), name);
  }
  return aligned_table(rows, Align::kLeft) +
         "In place of the emulator --fcu flies a board. PX4 and ArduPilot are stock firmware of "
         "this machine.\n";
}

}  // namespace cas::hils

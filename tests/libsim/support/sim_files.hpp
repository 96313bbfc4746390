// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "libsim/core/load/sim_config.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim::test {

inline const std::filesystem::path kSourceDir = cas::test::source_dir();
inline const std::filesystem::path kFakePluginDir =
    std::filesystem::path(cas::test::binary_dir()) / "tests" / "fake_plugins";
inline const std::string kIris = (kSourceDir / "config/vehicles/iris_paper.yaml").string();

/// The keys that every simulation has, apart from `world` and `vehicles`.
inline const std::string kHead = R"(schema: 1
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
decimal_year: 2026.5
pace: free_run
)";
inline const std::string kFlat = "world: {gravity_m_s2: 9.80665, ground: true}\n";

/// One vehicle of the list under `vehicles:`; `plugins` is a YAML flow list.
inline std::string vehicle(const std::string& name, const std::string& pose = "{}",
                           const std::string& plugins = "[]") {
  return "  - {name: " + name + ", vehicle: " + kIris + ", pose: " + pose +
         ", plugins: " + plugins + "}\n";
}

inline SimConfig config(const std::string& vehicles, const std::string& more = "",
                        const std::string& world = kFlat) {
  return SimConfig::parse(
      base::ConfigNode::parse(kHead + world + more + "vehicles:\n" + vehicles, "sim.yaml"));
}

inline SimOptions fake_plugins() { return {.output_dir = ".", .plugin_dirs = {kFakePluginDir}}; }

using cas::test::refusal;

}  // namespace cas::sim::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "libsim/core/run/sim_loop.hpp"

namespace cas::sim {

/// Answer to `sim.status`. Between steps, on the loop's thread.
nlohmann::json status_report(const SimLoop& loop);
/// What its plugins report, by "PLUGIN@VEHICLE"; a text where that is no JSON.
nlohmann::json plugin_figures(const SimRunner& runner);
/// The run's warnings: [{"vehicle": NAME or "", "warning": SENTENCE}, ...].
nlohmann::json warnings_report(const SimRunner& runner);
/// The report of `--stats` and `sim.stats`.
nlohmann::json stats_report(const SimLoop& loop);
/// The local endpoints that plugins have bound, "udp 127.0.0.1:14560 ...", for the ready message.
std::string endpoints_report(const SimRunner& runner);

/// Writes a file beside its place and renames it. @throws base::ConfigError
void write_report(const std::filesystem::path& file, const nlohmann::json& report);

}  // namespace cas::sim

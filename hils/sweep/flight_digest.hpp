// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hils/measure/run_result.hpp"

namespace cas::hils {

/// SHA-256 of files one after the other, as `cat FILES | sha256sum` prints it.
std::string sha256_of_files(const std::vector<std::filesystem::path>& files);

/// SHA-256 of the true motion of a run, vehicle by vehicle.
std::string truth_sha256(const RunResult& run);

/// SHA-256 of a run on the virtual clock: true motion, the vehicles' telemetry, and the times of
/// each HIL packet at its ends. Two runs with the same digest are the same.
std::string run_sha256(const RunResult& run);

}  // namespace cas::hils

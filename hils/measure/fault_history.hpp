// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hils/flight/bench_fault.hpp"

namespace cas::hils {

/// The faults of a vehicle as its plugin `fault` noted them in the simulator's figures; nothing
/// where there is no such file or no such plugin.
std::vector<BenchFaultScript::Span> vehicle_faults(const std::filesystem::path& simulator_stats,
                                                   const std::string& vehicle);

}  // namespace cas::hils

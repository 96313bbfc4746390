// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "hils/bench_fault.hpp"

namespace cas::hils {

/// The faults of the vehicle as plugin `fault` noted them in the simulator's figures; nothing where
/// there is no such file or no such plugin.
std::vector<BenchFaultScript::Span> vehicle_faults(const std::filesystem::path& simulator_stats);

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// Whether an instance flew another vehicle of the world than the one whose true motion it is
/// judged by: its first HOME_POSITION is where another vehicle started.
///
/// @param tlog  the flight log. An instance without a HOME_POSITION in it counts as the right one
/// @param system  of the instance
/// @return a sentence without a full stop; nullopt: it is the right one
std::optional<std::string> home_fault(const Scenario& scenario, std::size_t vehicle,
                                      const std::filesystem::path& tlog, std::uint8_t system);

}  // namespace cas::hils

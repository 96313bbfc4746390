// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// Whether nothing in an element of that name matters to a flight: visuals, sensors, plugins.
bool has_no_effect(std::string_view element);

/// Looks at the numbers of a <world> that matter to a flight, as the file has them: libsdformat
/// reads "-9,8" as -9 and says nothing.
/// @throws base::ConfigError "FILE:LINE: ..." for a number that is not one from its first to its
///     last character, and for one number too many
void require_whole_numbers(const sdf::ElementPtr& world);

}  // namespace cas::sim

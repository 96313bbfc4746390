// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "base/config/aero.hpp"
#include "base/config/config.hpp"
#include "base/config/output_use.hpp"

namespace cas::base {

/// Reads block `aero` of a vehicle file.
/// @param outputs  of the rotors; those of the control surfaces are added
/// @param tilts    of each rotor, which a panel's `in_wash_of` counts: whether a servo tilts it
/// @throws ConfigError when keys are missing (all of a block in one sentence) or out of range, when
///         an output is taken, and when a coefficient or panel names a surface that is not there
AeroParams read_aero(const ConfigNode& node, OutputUse& outputs, const std::vector<bool>& tilts);

}  // namespace cas::base

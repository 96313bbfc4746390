// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "libsim/core/export.hpp"

namespace cas::sim {

/// Every key of SimConfig with its default and meaning, as tables in Markdown: for `hilsim --keys`
/// and docs/reference/config.md.
CAS_SIM_EXPORT std::string simulation_reference();

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "base/config/model_body.hpp"

namespace cas::base {

/// Reads a URDF's text. Joints other than continuous ones count as fixed.
/// @return nullopt if the text is not a URDF
std::optional<ModelBody> read_urdf_body(const std::string& xml);

}  // namespace cas::base

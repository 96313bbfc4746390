// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "base/config/model_body.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Coefficients of a <plugin> that is a motor model of Gazebo, PX4 or RotorS: one with a
/// <motorConstant>, in N s^2. Nothing for any other plugin.
/// @param prefix  of the names of its model's links
/// @throws ConfigError "FILE:LINE: ..." for a coefficient that is no number
std::optional<ModelMotor> read_model_motor(const XmlElement& plugin, const std::string& prefix);

}  // namespace cas::base

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/config/model_builder.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Warns of unread parts of a vehicle's <model> (unread_elements.hpp), and of plugins and settings
/// that act on a vehicle in Gazebo alone. Nested models need calls of their own; visuals, sensors
/// and the contents of plugins are not checked.
/// @throws ConfigError for parameters of an <include>, which would make another model of it
void check_sdf_elements(const XmlElement& model, ModelBuilder& builder);

}  // namespace cas::base

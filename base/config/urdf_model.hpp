// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/config/model_body.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Reads a URDF as a vehicle: one tree of links, in which continuous joints are rotors and all
/// others fixed. Elements that say nothing about masses, places and shapes are passed over, but for
/// motor plugins in <gazebo>.
/// @throws ConfigError "FILE:LINE: ..." naming the element
ModelBody read_urdf_model(const XmlElement& robot, const std::filesystem::path& file,
                          const ModelParts& parts);

}  // namespace cas::base

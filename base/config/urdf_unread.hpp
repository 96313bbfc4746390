// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/config/model_builder.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Warns of what is not read of an <inertial>, <collision>, <visual> or <joint> of a URDF:
/// elements and attributes that no URDF has there, as of a slip of the pen (<orgin>, xzy='1 0 0'),
/// and an element that comes twice. Elements of other programs' namespaces are passed over.
/// @param who  begins the sentence: "link 'arm'"
void warn_of_unread_urdf(const XmlElement& part, const std::string& who, ModelBuilder& builder);

}  // namespace cas::base

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/config/model_body.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Where a format has the figures of a box, sphere, cylinder or mesh.
enum class FormValues {
  kElements,    ///< SDF: <box><size>1 1 1</size></box>
  kAttributes,  ///< URDF: <box size="1 1 1"/>
};

/// Form, size and mesh of the element in a <geometry>; other forms than these four are kOther.
/// @throws ConfigError for a figure that is missing or no number
void take_model_form(const XmlElement& form, FormValues values, ModelShape& shape);

}  // namespace cas::base

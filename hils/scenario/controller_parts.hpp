// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "hils/scenario/scenario.hpp"

namespace YAML {
class Node;
}

namespace cas::hils {

/// A vehicle's controller file, as yet without `seed`, `pace` and `line`.
YAML::Node controller_node(const Scenario& scenario, std::size_t vehicle);
/// Notes on the origin of a controller file's values, for errors.
std::string controller_origins(const Scenario& scenario, std::size_t vehicle);

}  // namespace cas::hils

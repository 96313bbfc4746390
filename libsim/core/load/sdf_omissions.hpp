// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// What a <world> element says and this simulator does not do: one sentence each, "FILE:LINE: who:
/// what". Of many of one kind the first three are named and the others counted. What changes
/// nothing is no omission: a value equal to the one that is simulated, pictures, lights, the
/// window.
std::vector<std::string> sdf_omissions(const sdf::ElementPtr& world);

/// "FILE:LINE" of an element.
std::string place_of(const sdf::Element& element);

}  // namespace cas::sim

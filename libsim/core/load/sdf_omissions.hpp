// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// Parts of a <world> element that this simulator does not support: one sentence each, "FILE:LINE:
/// who: what". Of one kind the first three are named and the others counted. Parts without effect
/// are no omissions: a value equal to the simulated one, visuals, lights, the window.
std::vector<std::string> sdf_omissions(const sdf::ElementPtr& world);

/// "FILE:LINE" of an element.
std::string place_of(const sdf::Element& element);

}  // namespace cas::sim

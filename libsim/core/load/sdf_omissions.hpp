// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// Features of a <world> element that this simulator does not support: one sentence each,
/// "FILE:LINE: who: what". Of many of one kind the first three are listed and the others counted.
/// Features without effect on the motion are not listed: values equal to the simulated ones,
/// pictures, lights, the window.
std::vector<std::string> sdf_omissions(const sdf::ElementPtr& world);

/// "FILE:LINE" of an element.
std::string place_of(const sdf::Element& element);

}  // namespace cas::sim

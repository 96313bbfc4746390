// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/rpc/description.hpp"

namespace cas::sim {

/// Description of the methods on hilsim's control socket, for `rpc.discover`.
///
/// @param version  of hilsim
base::rpc::Description control_description(std::string version);

}  // namespace cas::sim

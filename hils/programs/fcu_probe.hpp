// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/rpc/client.hpp"
#include "hils/programs/fcu_check.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// Looks at the controller through casd for some seconds, while the simulator's stream runs.
/// @throws RunStopped, base::rpc::ConnectionError
FcuFacts probe_fcu(base::rpc::Client& casd, Supervisor& supervisor, const std::string& device);

}  // namespace cas::hils

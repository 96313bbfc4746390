// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/rpc/client.hpp"
#include "hils/flight_plan.hpp"

namespace cas::hils {

/// What casd knows of the vehicle now; not heard when there is none yet.
VehicleReport vehicle_report(base::rpc::Client& casd);

/// Has casd give a step's commands. @return why one was refused; empty when all were accepted
std::string give(base::rpc::Client& casd, const FlightStep& step, bool not_hil);

}  // namespace cas::hils

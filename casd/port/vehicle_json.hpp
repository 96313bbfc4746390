// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "base/time/clock.hpp"
#include "casd/packet/intervention.hpp"
#include "casd/station/vehicle_state.hpp"

namespace cas::casd {

/// Name of a link in the topology.
using LinkName = std::function<std::string(LinkId)>;

/// A vehicle as casd.status lists it.
/// @param link_name  of the link that its HEARTBEATs come from
nlohmann::json summary_json(const VehicleState& vehicle, const LinkName& link_name,
                            base::RunTime now);

/// `at_s` of an answer: its time by the clock that casd stamps received packets with. Only
/// differences have a meaning, for example to a message that is `age_s` older.
double moment_s(base::RunTime now);

/// MAV_STATE of the HEARTBEAT in words: "standby", "active".
std::string_view state_word(mavlink::common::MavState state);

/// The answer of vehicle.state: the summary, and attitude, place and home as far as known.
nlohmann::json state_json(const VehicleState& vehicle, const LinkName& link_name,
                          base::RunTime now);

/// Acts of others on a vehicle, as vehicle.state lists them.
nlohmann::json interventions_json(const Interventions& interventions, const LinkName& link_name,
                                  base::RunTime now);

}  // namespace cas::casd

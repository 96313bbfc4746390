// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink_gen/services/command.hpp"
#include "mavlink_gen/services/command_exchange.hpp"
#include "mavlink_gen/services/motion.hpp"
#include "mavlink_gen/services/outcome.hpp"
#include "mavlink_gen/services/param_exchange.hpp"
#include "mavlink_gen/services/vehicle_modes.hpp"
#include "mavlink_gen/services/vehicle_state.hpp"

namespace cas::casd {

// Names of mav::services that the station uses.
using mav::services::addressee_of;
using mav::services::arm_command;
using mav::services::arming_checks;
using mav::services::ArmingChecks;
using mav::services::Autopilot;
using mav::services::autopilot_family;
using mav::services::CommandExchange;
using mav::services::CommandTiming;
using mav::services::complaints;
using mav::services::custom_mode;
using mav::services::describe;
using mav::services::Done;
using mav::services::failure;
using mav::services::from_wire;
using mav::services::Heard;
using mav::services::here_command;
using mav::services::interval_command;
using mav::services::kEkfStatusReport;
using mav::services::kVehicleTimeout;
using mav::services::leads_into_hil;
using mav::services::MessageMemory;
using mav::services::mode_command;
using mav::services::mode_words;
using mav::services::ModeSet;
using mav::services::Motion;
using mav::services::motion_of;
using mav::services::motion_of_parameter;
using mav::services::name;
using mav::services::number_text;
using mav::services::Outcome;
using mav::services::OutcomeKind;
using mav::services::ParamEncoding;
using mav::services::ParamExchange;
using mav::services::ParamTiming;
using mav::services::position_lack;
using mav::services::request_command;
using mav::services::StatusText;
using mav::services::stops;
using mav::services::VehicleCommand;

}  // namespace cas::casd

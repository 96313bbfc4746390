// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// Whether a vehicle is to fly by External AHRS: an ArduPilot whose SERVO_OUTPUT_RAW a route names
/// that does not lead to a ground station.
bool is_by_external_ahrs(const DoctorFacts& facts, const nlohmann::json& vehicle);

/// What an ArduPilot by External AHRS needs: consent to its live outputs, its parameters, and
/// SERVO_OUTPUT_RAW from it.
void check_external_ahrs(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

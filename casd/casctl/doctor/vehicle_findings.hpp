// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// Whether each vehicle is heard, alone with its id, and in HIL.
void check_vehicles(const DoctorFacts& facts, Findings& all);
/// HIL_SENSOR to each vehicle and controls from it.
void check_streams(const DoctorFacts& facts, Findings& all);
/// Whether a vehicle that is heard would arm: its state, its own arming checks and its complaints.
void check_readiness(const DoctorFacts& facts, Findings& all);
/// Other commanders: heartbeats of ground stations, and casd's own address from elsewhere.
void check_ground_stations(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

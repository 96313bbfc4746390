// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// Whether links are up, and what they lose.
void check_links(const DoctorFacts& facts, Findings& all);
/// Timestamps of signatures must rise, so one from the future shuts out all later packets.
void check_signing(const DoctorFacts& facts, Findings& all);
/// Load of each line against its rate.
void check_baud(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

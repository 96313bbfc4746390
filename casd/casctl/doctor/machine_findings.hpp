// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// Whether the serial devices of the links are there, may be opened, and answer at once.
void check_devices(const DoctorFacts& facts, Findings& all);
/// Frequency scaling, the wall clock, and how late threads wake.
void check_machine(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// Serial devices of the links.
void check_devices(const DoctorFacts& facts, Findings& all);
/// Gaps of the recording under way.
void check_recording(const DoctorFacts& facts, Findings& all);
/// Frequency scaling, the wall clock, and how late threads wake.
void check_machine(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

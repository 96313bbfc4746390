// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// Judges a set-up. Pure.
Findings diagnose(const DoctorFacts& facts);

}  // namespace cas::casctl

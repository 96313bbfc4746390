// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/doctor_facts.hpp"
#include "casd/casctl/doctor/finding.hpp"

namespace cas::casctl {

/// State and losses of each link.
void check_links(const DoctorFacts& facts, Findings& all);
/// Whether signatures are from the future: their timestamps must rise, so that one shuts out all
/// later packets.
void check_signing(const DoctorFacts& facts, Findings& all);
/// Whether each line carries its load in time.
void check_baud(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

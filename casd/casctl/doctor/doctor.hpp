// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/doctor/findings.hpp"
#include "casd/casctl/session/command_line.hpp"

namespace cas::casctl {

/// Looks at casd twice, `seconds` apart, and at this machine meanwhile.
DoctorFacts gather_facts(Session& session, double seconds);

void add_doctor_verb(CommandLine& line);

}  // namespace cas::casctl

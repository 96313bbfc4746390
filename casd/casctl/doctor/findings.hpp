// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "casd/casctl/doctor/doctor_facts.hpp"

namespace cas::casctl {

/// How a thing is that was looked at.
enum class Health { kGood, kWarning, kBad };

/// One thing that was looked at.
struct Finding {
  Health health = Health::kGood;
  std::string what;        ///< a sentence
  std::string remedy;      ///< advice; empty when all is well
  bool unchecked = false;  ///< of a vehicle that casd only routes for
};

using Findings = std::vector<Finding>;

// Each of these functions appends a finding.

inline void good(Findings& all, std::string what) {
  all.push_back({Health::kGood, std::move(what), "", false});
}

inline void warn(Findings& all, std::string what, std::string remedy) {
  all.push_back({Health::kWarning, std::move(what), std::move(remedy), false});
}

inline void bad(Findings& all, std::string what, std::string remedy) {
  all.push_back({Health::kBad, std::move(what), std::move(remedy), false});
}

/// Judges a set-up. Pure.
Findings diagnose(const DoctorFacts& facts);

/// State and losses of each link.
void check_links(const DoctorFacts& facts, Findings& all);
/// Whether signatures are from the future: their timestamps must rise, so that one shuts out all
/// later packets.
void check_signing(const DoctorFacts& facts, Findings& all);
/// Whether each line carries its load in time.
void check_baud(const DoctorFacts& facts, Findings& all);

/// Whether the serial devices of the links are there, may be opened, and answer at once.
void check_devices(const DoctorFacts& facts, Findings& all);
/// Frequency scaling, the wall clock, and how late threads wake.
void check_machine(const DoctorFacts& facts, Findings& all);

/// Whether each vehicle is heard, alone with its id, and in HIL.
void check_vehicles(const DoctorFacts& facts, Findings& all);
/// HIL_SENSOR to each vehicle and controls from it.
void check_streams(const DoctorFacts& facts, Findings& all);
/// Whether a vehicle that is heard would arm: its state, its own arming checks and its complaints.
void check_readiness(const DoctorFacts& facts, Findings& all);
/// Other commanders: heartbeats of ground stations, and casd's own address from elsewhere.
void check_ground_stations(const DoctorFacts& facts, Findings& all);

/// Whether a vehicle is to fly by External AHRS: an ArduPilot whose SERVO_OUTPUT_RAW a route names
/// that does not lead to a ground station.
bool is_by_external_ahrs(const DoctorFacts& facts, const nlohmann::json& vehicle);

/// What an ArduPilot by External AHRS needs: consent to its live outputs, its parameters, and
/// SERVO_OUTPUT_RAW from it.
void check_external_ahrs(const DoctorFacts& facts, Findings& all);

}  // namespace cas::casctl

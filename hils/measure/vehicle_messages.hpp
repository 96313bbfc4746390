// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace cas::hils {

struct RunRecord;

/// A message by which a vehicle shows that it noticed a fault or reacted to it.
struct VehicleSign {
  double time_s = 0;  ///< simulated
  std::string what;   ///< "STATUSTEXT 'Position lost: descending'", "health: GPS", "LAND"
  bool is_reaction = false;
};

/// A change of the armed state in a vehicle's HEARTBEATs.
struct ArmedChange {
  double time_s = 0;  ///< simulated
  bool armed = false;
};

/// Signs and armed states in a vehicle's messages, in the order of time.
struct VehicleMessages {
  /// STATUSTEXTs of warnings and worse that refuse no command; a health flag of SYS_STATUS that
  /// falls (that of the arming checks on the ground alone); MAV_STATE critical or worse. HEARTBEATs
  /// come each second, so that a reaction is known up to 1 s late.
  std::vector<VehicleSign> signs;
  std::vector<ArmedChange> armed;
};

/// Reads the messages of a run's vehicle from the flight log.
VehicleMessages read_vehicle_messages(const RunRecord& record);

}  // namespace cas::hils

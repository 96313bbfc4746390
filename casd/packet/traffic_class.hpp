// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace cas::casd {

/// What a packet is to a link that cannot carry everything.
enum class TrafficClass : std::uint8_t {
  kCommand,    ///< commands, parameters, missions, file transfer, heartbeats, time: never lost
  kHil,        ///< the HIL loop's sensor and actuator packets: worthless when late
  kGps,        ///< slow sensors of the HIL loop: worth more than one packet of the fast ones
  kTelemetry,  ///< everything else: yields
};
inline constexpr int kTrafficClasses = 4;

/// The class of a message by its id; ids that no public dialect knows are telemetry.
TrafficClass classify(std::uint32_t message_id);

std::string_view to_string(TrafficClass traffic);

}  // namespace cas::casd

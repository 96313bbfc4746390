// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::test {

/// A packet and when it was sent.
struct Said {
  base::RunTime at{};
  std::vector<std::uint8_t> bytes;

  mav::PacketView view() const { return mav::view_packet(bytes); }
};

/// What a vehicle, and casd, said to one another, in order.
using Conversation = std::vector<Said>;

/// A conversation of casd with stock firmware, from tests/firmware/recorded; times count from 100
/// s.
/// @throws std::runtime_error where there is none
Conversation recorded(const std::string& name);

/// What a vehicle tells of its readiness, by which casd decides whether to arm it. A scripted peer
/// that tells more than the firmware that it stands for lets tests pass that fail with the
/// firmware.
struct Manner {
  bool enables_checks = false;      ///< SYS_STATUS.enabled had the bit of the arming checks
  bool passes_checks = false;       ///< SYS_STATUS.health had it
  bool boots_uninit = false;        ///< its first HEARTBEAT said MAV_STATE_UNINIT
  bool stands_still_const = false;  ///< ESTIMATOR_STATUS on the ground, with a position, always has
                                    ///< CONST_POS_MODE
  double estimator_hz = 0;          ///< ESTIMATOR_STATUS
  std::set<std::uint32_t> messages;
};
Manner manner_of(const Conversation& conversation);

}  // namespace cas::test

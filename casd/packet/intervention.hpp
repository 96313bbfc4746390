// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Effect of a packet on a vehicle.
struct Act {
  std::string what{};    ///< "command 400 (arm)", "MANUAL_CONTROL"
  mav::Source target{};  ///< 0: every system, every component
  bool disarms = false;  ///< disarms or ends the flight, or may do so
};

/// Reads a command, sticks, a target or a change of the mission. nullopt: the packet only requests
/// information, or is of another kind.
std::optional<Act> act_of(const mav::PacketView& packet);
/// Reads a vehicle's answer to a command that arms, disarms or ends the flight: its addressee has
/// commanded the vehicle, perhaps over a link that casd does not see. The answer does not tell
/// arming from disarming and counts as both.
std::optional<Act> act_of(const mavlink::common::CommandAck& answer);
/// Whether a command only requests information.
bool only_asks(mavlink::common::MavCmd command);
/// Whether a packet is MAV_CMD_INJECT_FAILURE: casd's own station gives it to the simulator, and
/// vehicles never get it.
bool is_failure(const mav::PacketView& packet);
/// Whether a message may be an act or the answer to one, by its id alone.
bool may_be_act(std::uint32_t message_id);

/// An act of a station other than casd's own. Repetitions are counted in `times`.
struct Intervention {
  mav::Source by{};
  LinkId link = kNoLink;
  Act act{};
  std::uint64_t times = 1;
  base::RunTime at{};  ///< of the newest
};

/// The newest interventions of a vehicle, in the order in which they first came. Of those that
/// disarm at least one stays.
class Interventions {
 public:
  static constexpr std::size_t kMost = 20;

  void add(Intervention intervention);
  const std::deque<Intervention>& all() const { return all_; }

 private:
  std::deque<Intervention> all_;
};

}  // namespace cas::casd

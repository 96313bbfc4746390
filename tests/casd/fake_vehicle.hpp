// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd::test {

/// A scripted autopilot in virtual time: answers commands and parameters by its script, also
/// wrongly. Keeps received packets for the test.
class FakeVehicle {
 public:
  struct Script {
    mavlink::common::MavResult result = mavlink::common::MavResult::kAccepted;
    int answers = 1;                                      ///< COMMAND_ACKs per command: 0 is never
    base::Duration delay = std::chrono::milliseconds(5);  ///< of each answer
    int deaf_for = 0;                                     ///< commands and requests it misses first
    bool in_progress_first = false;
    bool beats_on_request = false;  ///< MAV_CMD_REQUEST_MESSAGE of HEARTBEAT
    bool keeps_mode = false;        ///< accepts another mode and stays in its own
    /// Answers once more, with this: PX4 1.16 does, asked for POSCTL without sticks.
    std::optional<mavlink::common::MavResult> then;
    std::string text;  ///< STATUSTEXT sent just after an ACK
    /// The command that is the last thing it answers; it says nothing else from then on.
    std::optional<mavlink::common::MavCmd> silent_from;
  };

  explicit FakeVehicle(mav::Source source = {1, 1}) : source_(source) {}

  Script script;
  mavlink::common::MavAutopilot autopilot = mavlink::common::MavAutopilot::kPx4;
  mavlink::common::MavType type = mavlink::common::MavType::kQuadrotor;
  mavlink::common::MavModeFlag base_mode =
      mavlink::common::MavModeFlag::kCustomModeEnabled | mavlink::common::MavModeFlag::kHilEnabled;
  std::uint32_t custom_mode = 0;
  struct Param {
    double value = 0;
    mavlink::common::MavParamType type = mavlink::common::MavParamType::kReal32;
    double high = 1e9;  ///< larger values are clamped
  };
  std::map<std::string, Param> params;
  std::vector<std::string> lost_in_list;  ///< left out of the next list
  std::string unsaid;                     ///< a parameter that it counts and never sends

  std::vector<mavlink::common::CommandLong> commands;
  std::vector<mavlink::common::CommandInt> int_commands;
  std::vector<mavlink::common::ParamSet> param_sets;
  std::vector<mavlink::common::ManualControl> sticks;
  int param_reads = 0;
  int heartbeats = 0;

  /// Takes in a packet from the ground station.
  void handle(const mav::PacketView& packet, base::RunTime now);
  /// Queues a message of its own.
  template <class M>
  void say(const M& message, base::RunTime at) {
    Outgoing out;
    out.at = at;
    out.packet.size = mav::encode(message, source_, sequence_++, out.packet.bytes);
    out_.push_back(out);
  }
  void say_heartbeat(base::RunTime at);
  void say_text(const std::string& text, base::RunTime at);
  /// The next packet that is due.
  std::optional<mav::PacketBuffer> take(base::RunTime now);

 private:
  struct Outgoing {
    base::RunTime at;
    mav::PacketBuffer packet;
  };

  bool deaf();
  void take_mode(const mavlink::common::CommandLong& command);
  void fall_silent(mavlink::common::MavCmd command);
  void answer(mavlink::common::MavCmd command, base::RunTime now);
  void on_param_set(const mavlink::common::ParamSet& message, base::RunTime now);
  void on_param_list(base::RunTime now);
  void say_param(const std::string& name, base::RunTime at, std::uint16_t index = 65535);

  mav::Source source_;
  std::uint8_t sequence_ = 0;
  std::deque<Outgoing> out_;
  bool silent_ = false;
};

}  // namespace cas::casd::test

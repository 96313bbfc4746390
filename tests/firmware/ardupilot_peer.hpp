// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "tests/firmware/conversation.hpp"
#include "tests/firmware/pilot.hpp"
#include "tests/firmware/scripted_ardupilot.hpp"

namespace cas::test {

/// A scripted ArduCopter that talks to a simulator over UDP as SITL does, and the pilot at its
/// ground station's link. Runs on the thread that calls run_until().
class ArdupilotPeer {
 public:
  ArdupilotPeer(std::uint16_t port, const ScriptedArdupilot::Options& options = {},
                const Pilot::Plan& plan = {});
  ~ArdupilotPeer();
  ArdupilotPeer(const ArdupilotPeer&) = delete;
  ArdupilotPeer& operator=(const ArdupilotPeer&) = delete;

  /// Sends a packet and waits for its answer, over and over, until the condition holds.
  /// @return false at the deadline
  template <class Condition>
  bool run_until(Condition&& condition, base::Duration patience = std::chrono::seconds(60)) {
    const base::RunTime deadline = base::steady_now() + patience;
    while (!condition()) {
      if (base::steady_now() > deadline) return false;
      pump();
    }
    return true;
  }

  void send_packet();
  /// The next answer within `patience`; empty when none comes.
  std::string receive(base::Duration patience);

  ScriptedArdupilot& ardupilot() { return *ardupilot_; }
  Pilot& pilot() { return pilot_; }
  /// All that the vehicle has sent to its ground station.
  const Conversation& said() const { return said_; }
  std::uint64_t repeats() const { return repeats_; }

 private:
  void pump();

  std::uint16_t port_;
  int socket_ = -1;
  std::uint64_t repeats_ = 0;
  Conversation said_;
  std::unique_ptr<ScriptedArdupilot> ardupilot_;
  Pilot pilot_;
};

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "tests/firmware/conversation.hpp"
#include "tests/firmware/pilot.hpp"
#include "tests/firmware/scripted_px4.hpp"

namespace cas::test {

/// A scripted PX4 that connects to a simulator over TCP as stock PX4 does, and the pilot at its
/// ground station's link. Runs on the thread that calls run_until().
class Px4SitlPeer {
 public:
  Px4SitlPeer(std::uint16_t port, const ScriptedPx4::Options& options,
              const Pilot::Plan& plan = {});
  ~Px4SitlPeer() { disconnect(); }
  Px4SitlPeer(const Px4SitlPeer&) = delete;
  Px4SitlPeer& operator=(const Px4SitlPeer&) = delete;

  /// Connects if needed, and handles packets until the condition holds.
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
  void disconnect();

  ScriptedPx4& px4() { return *px4_; }
  Pilot& pilot() { return pilot_; }
  /// All that the vehicle has sent to its ground station.
  const Conversation& said() const { return said_; }
  /// While set, samples are read and not answered.
  void set_deaf(bool deaf) { deaf_ = deaf; }

 private:
  void pump();
  bool connect();

  std::uint16_t port_;
  int socket_ = -1;
  bool deaf_ = false;
  Conversation said_;
  std::unique_ptr<ScriptedPx4> px4_;
  Pilot pilot_;
};

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "casd/link_set.hpp"
#include "tests/firmware/pilot.hpp"
#include "tests/firmware/running_simulation.hpp"
#include "tests/firmware/scripted_px4.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {

/// A scripted PX4 in HITL mode at the end of a serial line, in real time:
///
///   hilsim --UDP--> casd --PTY--> PX4;  pilot --UDP--> casd
///
/// Runs on the thread that calls run_until(); casd and the simulation have their own.
class Px4HitlFixture {
 public:
  /// @param baud  of casd's link: 0 is USB
  explicit Px4HitlFixture(const ScriptedPx4::Options& options, unsigned baud = 921600,
                          const Pilot::Plan& plan = {.not_hil = false});

  template <class Condition>
  bool run_until(Condition&& condition, base::Duration patience = std::chrono::seconds(60)) {
    const base::RunTime deadline = base::steady_now() + patience;
    while (!condition()) {
      if (base::steady_now() > deadline) return false;
      pump();
    }
    return true;
  }

  ScriptedPx4& px4() { return *px4_; }
  Pilot& pilot() { return *pilot_; }
  RunningSimulation& simulation() { return *simulation_; }
  /// When each HIL_SENSOR was read off the line.
  std::vector<base::RunTime>& arrivals() { return arrivals_; }
  /// Time since PX4's boot.
  base::RunTime now() const { return base::RunTime(base::steady_now() - boot_); }

 private:
  void pump();
  void start_casd(unsigned baud, std::uint16_t simulation_port);
  std::uint16_t port_of_link(const std::string& name) const;

  TemporaryFolder folder_;
  PtyPair line_;
  UdpPeer ground_;
  std::unique_ptr<casd::LinkSet> casd_;
  std::unique_ptr<RunningSimulation> simulation_;
  base::RunTime boot_;
  std::unique_ptr<ScriptedPx4> px4_;
  std::unique_ptr<Pilot> pilot_;
  std::vector<base::RunTime> arrivals_;
};

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hils/firmware/firmware_scenario.hpp"
#include "hils/firmware/pty_cable.hpp"
#include "hils/programs/flight_logs.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// casd, hilsim and the firmware as programs, in this order, so that the firmware finds its peers;
/// of several vehicles each has a firmware of its own.
class FirmwareBench {
 public:
  FirmwareBench(const FirmwareScenario& scenario, const FirmwarePlaces& places);

  void start();
  /// The exit code of the firmware says nothing about the flight.
  void stop();

  /// Ends the firmware of one vehicle, and starts it again in its folder. Its log goes on.
  void reboot(std::size_t vehicle);

  /// A fault: casd is gone at once.
  void kill_casd();
  void start_casd();
  /// The serial line of a firmware that has one.
  PtyCable& cable() { return *cable_; }

  Supervisor& supervisor() { return supervisor_; }
  /// Bytes that the serial line lost because a program did not read them.
  std::uint64_t lost_bytes() const { return cable_ ? cable_->lost_bytes() : 0; }

 private:
  ChildProcess::Options options(const std::string& name, std::vector<std::string> arguments) const;
  ChildProcess::Options firmware_options(std::size_t instance) const;

  const FirmwareScenario& scenario_;
  const FirmwarePlaces& places_;
  Supervisor supervisor_;
  std::optional<PtyCable> cable_;
  FlightLogs logs_;
  ChildProcess* casd_ = nullptr;
  ChildProcess* hilsim_ = nullptr;
  std::vector<ChildProcess*> firmware_;
};

}  // namespace cas::hils

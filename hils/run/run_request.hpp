// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "hils/run/station_endpoint.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

class LiveRun;

/// A real controller, in the place of the emulator or of a stock firmware as a program.
struct FcuDevice {
  std::string path;  ///< its serial port
  unsigned baud = 921600;
  std::string sensors_path{};  ///< where its External AHRS is connected; empty: it has none
  /// The user's word that nothing is connected to its outputs.
  bool outputs_disconnected = false;
};

/// What moves the time of a run on.
enum class Clock : std::uint8_t {
  kWall,      ///< real time
  kLockstep,  ///< the stream's: the programs wait for each other, as fast as it goes
  kVirtual,   ///< it is computed, in one process; not for stock firmware
};

/// The clock of a run that nobody watches.
inline Clock fastest_clock(const Scenario& scenario) {
  return scenario.firmware ? Clock::kLockstep : Clock::kVirtual;
}

/// One run of a scenario.
struct RunRequest {
  Scenario scenario;
  Architecture architecture = Architecture::kTcas;
  std::uint64_t seed = 1;
  std::string line_preset{};  ///< instead of the scenario's; empty: the scenario's
  /// Real controllers, by the vehicle's place in the scenario; the other vehicles have the
  /// emulator.
  std::map<std::size_t, FcuDevice> fcu_devices{};
  Clock clock = Clock::kWall;
  bool announced = false;                    ///< says how to watch it once casd is ready
  bool beside_paper = false;                 ///< reports show the rows of [HILS] below ours
  bool keeps_sensors = true;                 ///< leaves each sensor's samples as CSV
  LiveRun* live = nullptr;                   ///< shows it in a browser; nullptr: it is not shown
  std::optional<StationEndpoint> station{};  ///< where a ground station may join; nullopt: none
  std::filesystem::path
      out{};  ///< folder of the results; the programs' configurations are in out/run

  /// Whether the virtual clock flies it.
  bool is_computed() const {
    return !scenario.firmware &&
           (clock == Clock::kVirtual || architecture == Architecture::kDirect);
  }
  /// The vehicle's real controller; nullptr: it has the emulator.
  const FcuDevice* fcu_device(std::size_t vehicle) const {
    const auto found = fcu_devices.find(vehicle);
    return found == fcu_devices.end() ? nullptr : &found->second;
  }
};

}  // namespace cas::hils

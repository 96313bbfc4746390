// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/firmware/firmware_scenario.hpp"

namespace cas::hils {

/// Where the pieces of a flight of stock firmware are.
struct FirmwarePlaces {
  std::filesystem::path out;      ///< results: truth.csv, flight.tlog, summary.json
  std::filesystem::path run;      ///< effective configurations, figures, program output
  std::filesystem::path sockets;  ///< short-lived: control sockets, ends of the serial line

  std::filesystem::path simulator_config() const { return run / "hilsim.yaml"; }
  std::filesystem::path casd_config() const { return run / "casd.yaml"; }
  std::filesystem::path simulator_control() const { return sockets / "hilsim"; }
  std::filesystem::path command_port() const { return sockets / "casd"; }
  std::filesystem::path casd_tty() const { return sockets / "casd_tty"; }
  std::filesystem::path firmware_tty() const { return sockets / "firmware_tty"; }
};

/// Writes the scenario's world and topology as the programs are given them: with a recorder,
/// control sockets in the run's folder and casd's serial link at the firmware's line. @throws
/// base::ConfigError
void write_firmware_configs(const FirmwareScenario& scenario, const FirmwarePlaces& places);

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "hils/run/station_endpoint.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// One run of a scenario.
struct RunRequest {
  Scenario scenario;
  Architecture architecture = Architecture::kTcas;
  std::uint64_t seed = 1;
  std::string line_preset{};  ///< instead of the scenario's; empty: the scenario's
  std::string fcu_device{};   ///< a real controller's serial port; empty: the emulator
  unsigned fcu_baud = 921600;
  bool lockstep = false;                     ///< the processes run on the stream's time
  bool announced = false;                    ///< says how to watch it once casd is ready
  bool web = false;                          ///< casweb shows it in a browser
  std::optional<StationEndpoint> station{};  ///< where a ground station may join; nothing: none
  std::filesystem::path
      out;  ///< folder of the results; the programs' configurations are in out/run
};

}  // namespace cas::hils

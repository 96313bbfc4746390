// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/programs/flown_simulator.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_request.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

/// What all vehicles of a flight of stock firmware share.
struct FlightDeck {
  FlightDeck(const Scenario& flown, const RunPaths& paths, FirmwareBench& programs)
      : scenario(flown),
        bench(programs),
        supervisor(programs.supervisor()),
        run(paths.run),
        casd_address("unix:" + paths.command_port.string()),
        simulator(paths.simulator_control()),
        casd(connect(casd_address)) {}

  const Scenario& scenario;
  FirmwareBench& bench;
  Supervisor& supervisor;
  std::filesystem::path run;
  std::string casd_address;
  FlownSimulator simulator;
  FcuDevice vehicle_line{};             ///< casd's end of the line to the firmware
  base::rpc::Client casd;               ///< replaced when casd is started again
  std::function<base::SimTime()> look;  ///< at the simulation, for all vehicles
};

}  // namespace cas::hils

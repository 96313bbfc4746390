// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/realtime_run.hpp"

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "hils/programs/bench_programs.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/fcu_device.hpp"
#include "hils/programs/ground_station_thread.hpp"
#include "hils/programs/realtime_pilot.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_directory.hpp"
#include "hils/run/run_places.hpp"

namespace cas::hils {

namespace {

/// Nothing where casd was killed: what it had noted by then is gone.
std::map<std::string, casd::LinkLedger> read_relay_ledgers(const RunPlaces& places,
                                                           const Scenario& scenario) {
  for (const BenchFault& fault : scenario.faults.bench) {
    if (std::holds_alternative<RestartFault>(fault.kind)) return {};
  }
  return casd::read_link_ledgers(places.casd_ledger());
}

void add_relay(std::map<std::string, casd::LinkLedger>& ledgers, const VehiclePlaces& places,
               RunRecord& record) {
  const auto simulator = ledgers.find(places.simulator_link);
  const auto controller = ledgers.find(places.controller_link);
  if (simulator == ledgers.end() || controller == ledgers.end()) return;
  record.relay = RelayLedgers{.simulator = std::move(simulator->second),
                              .controller = std::move(controller->second)};
}

/// What the programs have written down, when they have ended.
void read_ledgers(const RunRequest& request, const RunPlaces& places,
                  std::vector<RunRecord>& records) {
  auto relay = read_relay_ledgers(places, request.scenario);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const VehiclePlaces& vehicle = places.vehicles[i];
    records[i].simulator = base::PacketLedger::read(vehicle.simulator_ledger());
    add_vehicle_faults(places, records[i]);
    add_relay(relay, vehicle, records[i]);
    if (request.fcu_device.empty()) {
      records[i].controller = base::PacketLedger::read(vehicle.controller_ledger());
    } else {
      stand_in_for_controller(places, records[i]);
    }
  }
}

}  // namespace

std::vector<RunRecord> run_in_real_time(const RunRequest& request) {
  refuse_emulator_faults(request);
  const base::RunTime begin = base::steady_now();
  const RunDirectory sockets;
  RunPlaces places = RunPlaces::of(request.scenario, request.out, sockets.path());
  places.choose_ports();
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  std::optional<GroundStationThread> ground_station;
  if (request.scenario.ground_station) {
    ground_station.emplace(request.scenario.systems());
    places.ground_station_port = ground_station->port();
  }
  write_configs(request, Transport::kUdp, places);

  std::vector<RunRecord> records = records_of(request.scenario, places);
  BenchPrograms programs(supervisor, places, request.fcu_device.empty());
  programs.start();
  try {
    if (!request.fcu_device.empty()) check_device(supervisor, places, request);
    RealtimePilot(supervisor, programs, places, request,
                  ground_station ? &*ground_station : nullptr)
        .fly(records);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(
        std::chrono::milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  programs.stop();
  const double wall_s = base::to_seconds(base::steady_now() - begin);
  for (RunRecord& record : records) {
    record.wall_s = wall_s;
    record.cpu_s = supervisor.cpu_s();
  }
  read_ledgers(request, places, records);
  return records;
}

}  // namespace cas::hils

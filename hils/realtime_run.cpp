// SPDX-License-Identifier: BSD-3-Clause
#include "hils/realtime_run.hpp"

#include <chrono>
#include <optional>
#include <utility>
#include <variant>

#include "base/clock.hpp"
#include "base/rpc/client.hpp"
#include "base/vehicle.hpp"
#include "hils/bench_programs.hpp"
#include "hils/composition.hpp"
#include "hils/fault_history.hpp"
#include "hils/fcu_device.hpp"
#include "hils/ground_station_thread.hpp"
#include "hils/realtime_pilot.hpp"
#include "hils/run_directory.hpp"
#include "hils/supervisor.hpp"

namespace cas::hils {

namespace {

/// Nothing where casd noted nothing, or was killed: what it had noted by then is gone.
std::optional<RelayLedgers> read_relay_ledgers(const RunPlaces& places, const Scenario& scenario) {
  for (const BenchFault& fault : scenario.faults.bench) {
    if (std::holds_alternative<RestartFault>(fault.kind)) return std::nullopt;
  }
  auto ledgers = casd::read_link_ledgers(places.casd_ledger());
  if (!ledgers.contains("sim") || !ledgers.contains("fcu")) return std::nullopt;
  return RelayLedgers{.simulator = std::move(ledgers["sim"]),
                      .controller = std::move(ledgers["fcu"])};
}

}  // namespace

RunRecord run_in_real_time(const RunRequest& request) {
  refuse_emulator_faults(request);
  const base::RunTime begin = base::steady_now();
  const RunDirectory sockets;
  const std::vector<std::uint16_t> ports = free_udp_ports(2);
  RunPlaces places{.out = request.out,
                   .run = request.out / "run",
                   .sockets = sockets.path(),
                   .simulator_port = ports[0],
                   .casd_port = ports[1]};
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  std::optional<GroundStationThread> ground_station;
  if (request.scenario.ground_station) {
    ground_station.emplace(base::Vehicle::load(request.scenario.vehicle).system_id);
    places.ground_station_port = ground_station->port();
  }
  write_configs(request, Transport::kUdp, places);

  RunRecord record;
  record.truth_csv = places.truth_csv();
  record.flight_tlog = places.flight_tlog();
  BenchPrograms programs(supervisor, places, request.fcu_device.empty());
  programs.start();
  try {
    if (!request.fcu_device.empty()) check_device(supervisor, places, request);
    RealtimePilot(supervisor, programs, places, request,
                  ground_station ? &*ground_station : nullptr)
        .fly(record);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(
        std::chrono::milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  programs.stop();
  record.wall_s = base::to_seconds(base::steady_now() - begin);
  record.cpu_s = supervisor.cpu_s();
  record.simulator = base::PacketLedger::read(places.simulator_ledger());
  for (auto& fault : vehicle_faults(places.simulator_stats())) {
    record.faults.push_back(std::move(fault));
  }
  record.relay = read_relay_ledgers(places, request.scenario);
  if (request.fcu_device.empty()) {
    record.controller = base::PacketLedger::read(places.controller_ledger());
  } else {
    stand_in_for_controller(places, record);
  }
  return record;
}

}  // namespace cas::hils

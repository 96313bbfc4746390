// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "base/os/private_network.hpp"
#include "base/read_file.hpp"
#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "casd/counters/link_ledger.hpp"
#include "hils/firmware/external_ahrs.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/firmware/firmware_composition.hpp"
#include "hils/firmware/firmware_pilot.hpp"
#include "hils/firmware/own_home.hpp"
#include "hils/programs/fcu_device.hpp"
#include "hils/programs/live_run.hpp"
#include "hils/run/run_paths.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {
namespace {

using mavlink::common::HilSensor;

bool has_sensors(const casd::LinkLedger::Entries& entries) {
  return std::ranges::any_of(entries,
                             [](const auto& entry) { return entry.message_id == HilSensor::kId; });
}

/// The ledger of a casd that was killed, or of a link that was closed, is lost; the next begins
/// later.
bool loses_ledger(const Scenario& scenario) {
  return std::ranges::any_of(scenario.faults.bench, [](const BenchFault& fault) {
    return std::holds_alternative<RestartFault>(fault.kind) ||
           std::holds_alternative<CutFault>(fault.kind);
  });
}

/// casd's ledgers of the links that take HIL_SENSOR in and send it.
RelayLedgers read_relay(const std::filesystem::path& file) {
  RelayLedgers relay;
  for (auto& [link, ledger] : casd::read_link_ledgers(file)) {
    if (has_sensors(ledger.received())) {
      relay.simulator = std::move(ledger);
    } else if (has_sensors(ledger.sent())) {
      relay.controller = std::move(ledger);
    }
  }
  return relay;
}

/// The HIL stream between the simulator and casd's serial port, in HITL.
void read_ledgers(const Scenario& scenario, const RunPaths& paths, RunRecord& record) {
  const std::filesystem::path ledger = paths.vehicles.front().simulator_ledger();
  if (!scenario.firmware->on_serial_line || !std::filesystem::exists(ledger)) return;
  record.simulator = base::PacketLedger::read(ledger);
  if (!loses_ledger(scenario) && std::filesystem::exists(paths.casd_ledger())) {
    record.relay = read_relay(paths.casd_ledger());
  }
  stand_in_for_controller(record);
}

/// What the sensors' line carried. The turns by which hils has seen that the board follows are its
/// own act, and no fault of the flight.
void read_ahrs(const RunPaths& paths, RunRecord& record) {
  const std::string text = base::read_file(paths.simulator_stats()).value_or("");
  record.firmware->ahrs = ahrs_figures(nlohmann::json::parse(text, nullptr, false), record.vehicle)
                              .value_or(AhrsFigures{});
  std::erase_if(record.faults, [](const auto& fault) { return fault.name == kIdentification; });
}

/// Flights at once must not share the ports of world and topology.
void take_own_ports() {
  if (const auto why = base::enter_private_network()) {
    fmt::print(stderr, "hils: the flight uses this machine's ports, one flight at a time: {}\n",
               *why);
  }
}

/// Adds what the programs left behind.
void add_recordings(const Scenario& scenario, const RunPaths& paths,
                    std::vector<RunRecord>& records) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    add_simulator_report(paths, records[i]);
    read_ledgers(scenario, paths, records[i]);
    if (scenario.firmware->external_ahrs) read_ahrs(paths, records[i]);
    if (!scenario.flies_several()) continue;
    const auto other = home_fault(scenario, i, paths.flight_tlog(), records[i].system);
    if (other) records[i].firmware->not_its_own.push_back(*other);
  }
}

std::vector<RunRecord> fly_firmware(const RunRequest& request) {
  const Scenario& scenario = request.scenario;
  check_firmware_board(request);
  if (scenario.firmware->external_ahrs) warn_of_live_outputs();
  if (request.clock == Clock::kLockstep) take_own_ports();
  const RunDirectory sockets;
  RunPaths paths = RunPaths::of(scenario, request.out, sockets.path());
  paths.command_port = sockets.command_socket();
  std::vector<std::unique_ptr<CompanionLink>> companions;
  if (needs_companion(scenario)) {
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      companions.push_back(std::make_unique<CompanionLink>());
      paths.companions.push_back(companions.back()->port());
    }
  }
  write_firmware_configs(request, paths);
  std::vector<RunRecord> records = records_of(scenario, paths);
  FirmwareBench bench(request, paths);
  const base::RunTime begin = base::steady_now();
  try {
    bench.start();
    if (request.live != nullptr) request.live->start(request, paths, bench.supervisor());
    pilot_firmware(request, paths, bench, companions, records);
  } catch (const base::rpc::ConnectionError& error) {
    bench.supervisor().wait(std::chrono::milliseconds(500));  // a program that died is noticed
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  bench.stop();
  for (RunRecord& record : records) {
    record.wall_s = base::to_seconds(base::steady_now() - begin);
    record.cpu_s = bench.supervisor().cpu_s();
    std::ranges::copy(bench.remarks(), std::back_inserter(record.firmware->remarks));
    if (bench.lost_bytes() > 0) {
      record.firmware->remarks.push_back(fmt::format(
          "the serial line lost {} bytes that were not read in time", bench.lost_bytes()));
    }
  }
  add_recordings(scenario, paths, records);
  return records;
}

}  // namespace

std::vector<RunRecord> run_firmware(const RunRequest& request) {
  try {
    return fly_firmware(request);
  } catch (const std::exception& error) {
    if (request.live != nullptr) request.live->tell_end(error.what());
    throw;
  }
}

}  // namespace cas::hils

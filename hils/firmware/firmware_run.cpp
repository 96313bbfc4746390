// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_run.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/earth/deg_e7.hpp"
#include "base/earth/geodesy.hpp"
#include "base/os/private_network.hpp"
#include "base/read_file.hpp"
#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "casd/counters/link_ledger.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "hils/firmware/external_ahrs.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/firmware/firmware_composition.hpp"
#include "hils/firmware/firmware_pilot.hpp"
#include "hils/programs/fcu_device.hpp"
#include "hils/programs/live_run.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/scenario/scenario.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {
namespace {

using mavlink::common::HilSensor;

/// A stock autopilot's home is off by as much.
constexpr double kOff_m = 2;

std::optional<base::Geodetic> first_home(const std::filesystem::path& tlog, std::uint8_t system) {
  std::optional<base::Geodetic> first;
  casd::for_each_tlog_packet(tlog, mavlink::common::table(),
                             [&](std::uint64_t, const mav::PacketView& packet) {
                               if (first || packet.source.system != system) return;
                               const auto home = mav::decode<mavlink::common::HomePosition>(packet);
                               if (!home) return;
                               first = {.lat_deg = base::degrees_of_e7(home->latitude),
                                        .lon_deg = base::degrees_of_e7(home->longitude)};
                             });
  return first;
}

/// Whether an instance flew another vehicle of the world than the one whose true motion it is
/// judged by: its first HOME_POSITION is where another vehicle started.
///
/// @param tlog  the flight log. An instance without a HOME_POSITION in it counts as the right one
/// @param system  of the instance
/// @return a sentence without a full stop; nullopt: it is the right one
std::optional<std::string> home_fault(const Scenario& scenario, std::size_t vehicle,
                                      const std::filesystem::path& tlog, std::uint8_t system) {
  const auto home = first_home(tlog, system);
  if (!home || !scenario.home) return std::nullopt;
  const Eigen::Vector2d home_m = base::LocalProjection(*scenario.home)
                                     .to_local({home->lat_deg, home->lon_deg, scenario.home->alt_m})
                                     .head<2>();
  std::vector<Eigen::Vector2d> starts;  // north, east; a pose is x to the east, y to the north
  for (const ScenarioVehicle& each : scenario.vehicles) {
    starts.emplace_back(each.pose.y_m, each.pose.x_m);
  }
  const auto off_m = [&home_m](const Eigen::Vector2d& start) { return (home_m - start).norm(); };
  const auto nearest = std::ranges::min_element(starts, {}, off_m);
  if (off_m(starts.at(vehicle)) <= off_m(*nearest) + kOff_m) return std::nullopt;
  return fmt::format("system {} has its home where vehicle '{}' started, and not '{}'", system,
                     scenario.vehicles.at(static_cast<std::size_t>(nearest - starts.begin())).name,
                     scenario.vehicles.at(vehicle).name);
}

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

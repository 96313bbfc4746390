// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/hitl_stream.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "casd/counters/link_ledger.hpp"
#include "hils/programs/fcu_device.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {
namespace {

using mavlink::common::HilSensor;

constexpr base::Duration kLeast = std::chrono::seconds(1);
/// Of HIL_ACTUATOR_CONTROLS, as PX4 streams it in HIL mode.
constexpr double kControls_hz = 200;

bool has_sensors(const casd::LinkLedger::Entries& entries) {
  return std::ranges::any_of(entries,
                             [](const auto& entry) { return entry.message_id == HilSensor::kId; });
}

/// The ledger of a casd that was killed, or of a link that was closed, is lost; the next begins
/// later.
bool loses_ledger(const FirmwareScenario& scenario) {
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

/// Rate of HIL_SENSOR by its stamps.
double sensor_hz(const std::vector<base::LedgerEntry>& ledger, StreamWindow window) {
  std::uint64_t count = 0;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction != base::LedgerEntry::Direction::kSent) continue;
    if (entry.message_id != HilSensor::kId || !window.holds(entry.time_usec)) continue;
    if (count++ == 0) first = entry.time_usec;
    last = entry.time_usec;
  }
  return last > first ? 1e6 * static_cast<double>(count - 1) / static_cast<double>(last - first)
                      : 0;
}

}  // namespace

std::optional<StreamWindow> machine_window(const FirmwareFigures& figures) {
  const std::vector<Stage> flown = figures.flown_stages();
  if (flown.empty()) return std::nullopt;
  base::SimTime begin = flown.front().begin;
  base::SimTime end = flown.back().end;
  const auto measured =
      std::ranges::find_if(figures.stages, [](const Stage& stage) { return stage.step.measure; });
  const bool good = !figures.flight_failure && figures.incidents.empty();
  if (good && measured != figures.stages.end()) {
    begin = measured->begin;
    end = measured->end;
  }
  for (const BenchFaultScript::Span& fault : figures.bench_faults) end = std::min(end, fault.begin);
  if (figures.fell_silent) end = std::min(end, *figures.fell_silent);
  if (end - begin < kLeast) begin = flown.front().begin;
  if (end - begin < kLeast) return std::nullopt;
  return StreamWindow{base::to_time_usec(begin), base::to_time_usec(end)};
}

std::optional<Measurement> measure_hitl_stream(const FirmwareScenario& scenario,
                                               const FirmwarePlaces& places,
                                               const FirmwareFigures& figures) {
  const auto window = machine_window(figures);
  if (!window || !std::filesystem::exists(places.simulator_ledger())) return std::nullopt;
  RunRecord record;
  record.simulator = base::PacketLedger::read(places.simulator_ledger());
  if (!loses_ledger(scenario) && std::filesystem::exists(places.casd_ledger())) {
    record.relay = read_relay(places.casd_ledger());
  }
  stand_in_for_controller(record);
  Measurement stream;
  stream.window = *window;
  stream.from_device = true;
  const double hz = sensor_hz(record.simulator, *window);
  if (hz == 0) return std::nullopt;
  measure_stream({.sensor_hz = hz, .controls_hz = kControls_hz}, record, stream);
  if (record.relay) stream.port_gap_ms = longest_gap_ms(record, HilSensor::kId, *window);
  return stream;
}

}  // namespace cas::hils

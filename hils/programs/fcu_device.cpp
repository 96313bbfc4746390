// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/fcu_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>

#include "base/error.hpp"
#include "base/read_file.hpp"
#include "base/rpc/client.hpp"
#include "base/text.hpp"
#include "base/time/clock.hpp"
#include "hils/programs/fcu_check.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::milliseconds;
using std::chrono::seconds;

std::uint64_t sequence_gaps(const std::filesystem::path& casd_stats, const std::string& name) {
  const std::optional<std::string> text = base::read_file(casd_stats);
  if (!text) throw base::ConfigError(casd_stats.string() + ": figures of casd cannot be read");
  const Json stats = Json::parse(*text, nullptr, false);
  if (!stats.is_object()) return 0;
  for (const Json& link : stats.value("links", Json::array())) {
    if (link.value("name", "") == name) {
      return link.value("rx", Json::object()).value("lost", std::uint64_t{0});
    }
  }
  return 0;
}

bool is_control(const base::LedgerEntry& entry) {
  return entry.message_id == mavlink::common::HilControls::kId ||
         entry.message_id == mavlink::common::HilActuatorControls::kId;
}

/// Stamp of the newest HIL_SENSOR that had been sent by then.
std::int64_t sensor_stamp_at(const std::vector<base::LedgerEntry>& simulator, std::int64_t at_ns) {
  std::int64_t stamp = 0;
  for (const base::LedgerEntry& entry : simulator) {
    if (entry.at_ns > at_ns) break;
    if (entry.message_id == mavlink::common::HilSensor::kId) {
      stamp = static_cast<std::int64_t>(entry.time_usec);
    }
  }
  return stamp;
}

constexpr base::Duration kHeartbeatPatience = seconds(10);
constexpr base::Duration kLook = milliseconds(200);
/// casd's rates are over the last seconds.
constexpr base::Duration kSettle = seconds(4);

/// Where casd has a controller.
struct ProbedFcu {
  std::string link;      ///< casd's
  AskedVehicle vehicle;  ///< nothing: the only one there is

  Json about(Json params) const {
    if (vehicle) params["vehicle"] = *vehicle;
    return params;
  }
};

void read_link(base::rpc::Client& casd, const ProbedFcu& fcu, FcuFacts& facts) {
  const Json status = casd.call("casd.status", Json::object());
  for (const Json& link : status.value("links", Json::array())) {
    if (link.value("name", "") != fcu.link) continue;
    facts.link_up = link.value("state", "") == "up";
    facts.link_words = link.value("endpoint", "");
    facts.crc_errors = link.value("rx", Json::object()).value("crc_errors", 0.0);
  }
}

void read_vehicle(base::rpc::Client& casd, const ProbedFcu& fcu, FcuFacts& facts) {
  try {
    const Json state = casd.call("vehicle.state", fcu.about(Json::object()));
    facts.heard = true;
    const std::string link = state.value("link", fcu.link);
    facts.elsewhere = link == fcu.link ? "" : link;
    facts.hil = state.value("hil", false);
    facts.armed = state.value("armed", false);
    facts.autopilot = base::lower(state.value("autopilot", ""));
  } catch (const base::rpc::CallError& error) {
    if (error.code() != base::rpc::kNoSuchVehicle) throw;
  }
}

std::optional<double> read_param(base::rpc::Client& casd, const ProbedFcu& fcu,
                                 const std::string& name) {
  try {
    return casd.call("param.get", fcu.about({{"name", name}})).value("value", 0.0);
  } catch (const base::rpc::CallError&) {
    return std::nullopt;  // this firmware has none of that name
  }
}

void read_rates(base::rpc::Client& casd, const ProbedFcu& fcu, FcuFacts& facts) {
  const Json answer = casd.call("message.list", {{"link", fcu.link}});
  const Json list = answer.is_array() ? answer : answer.value("messages", Json::array());
  for (const Json& message : list) {
    const std::string name = message.value("name", "");
    const std::string way = message.value("direction", "");
    if (way == "tx" && name == "HIL_SENSOR") facts.sensor_hz += message.value("hz", 0.0);
    if (way == "rx" && (name == "HIL_CONTROLS" || name == "HIL_ACTUATOR_CONTROLS")) {
      facts.controls_hz += message.value("hz", 0.0);
      facts.by_rotor = name == "HIL_ACTUATOR_CONTROLS";
    }
  }
}

/// Looks at the controller through casd for some seconds, while the simulator's stream runs.
/// @throws RunStopped, base::rpc::ConnectionError
FcuFacts probe_fcu(base::rpc::Client& casd, Supervisor& supervisor, const ProbedFcu& fcu,
                   const std::string& device) {
  FcuFacts facts{.device = device, .system = fcu.vehicle};
  const base::RunTime deadline = base::steady_now() + kHeartbeatPatience;
  while (!facts.heard && base::steady_now() < deadline) {
    read_link(casd, fcu, facts);
    read_vehicle(casd, fcu, facts);
    supervisor.wait(kLook);
  }
  if (!facts.heard) return facts;
  supervisor.wait(kSettle);
  read_link(casd, fcu, facts);
  read_vehicle(casd, fcu, facts);
  read_rates(casd, fcu, facts);
  if (facts.autopilot == "px4") facts.sys_hitl = read_param(casd, fcu, "SYS_HITL");
  return facts;
}

}  // namespace

void refuse_emulator_faults(const RunRequest& request) {
  for (const BenchFault& fault : request.scenario.faults.bench) {
    if (request.fcu_device(fault.vehicle) == nullptr) continue;
    if (std::holds_alternative<LineFault>(fault.kind) ||
        std::holds_alternative<UnplugFault>(fault.kind)) {
      throw base::ConfigError("fault '" + fault.name +
                              "' needs the emulated line: a real port cannot play it");
    }
  }
}

void check_devices(Supervisor& supervisor, const RunPaths& paths, const RunRequest& request) {
  if (request.fcu_devices.empty()) return;
  base::rpc::Client casd = connect("unix:" + paths.command_port.string());
  bool ready = true;
  for (const auto& [place, device] : request.fcu_devices) {
    const ScenarioVehicle& own = request.scenario.vehicles.at(place);
    const ProbedFcu fcu{
        .link = paths.vehicles.at(place).controller_link,
        .vehicle = request.scenario.flies_several() ? AskedVehicle(own.system_id) : std::nullopt};
    const FcuFacts facts = probe_fcu(casd, supervisor, fcu, device.path);
    const std::vector<FcuFinding> findings =
        check_fcu(facts, request.scenario.rates, base::Vehicle::load(own.vehicle));
    fmt::print(stderr, "{}\n{}", device.path, findings_text(findings));
    ready = ready && may_fly(findings);
  }
  if (!ready) {
    throw RunStopped("the controller is not ready; the steps are in docs/use/pixhawk.md", false);
  }
}

void stand_in_for_controller(const RunPaths& paths, const VehiclePaths& vehicle,
                             RunRecord& record) {
  record.lost_by_sequence = sequence_gaps(paths.casd_stats(), vehicle.controller_link);
  stand_in_for_controller(record);
}

void stand_in_for_controller(RunRecord& record) {
  using Direction = base::LedgerEntry::Direction;
  record.from_device = true;
  if (!record.relay) return;
  for (const casd::LinkLedgerEntry& entry : record.relay->controller.sent()) {
    record.controller.push_back(
        {Direction::kReceived, entry.message_id, entry.time_usec, entry.at_ns});
  }
  for (const casd::LinkLedgerEntry& entry : record.relay->controller.received()) {
    record.controller.push_back({Direction::kSent, entry.message_id, entry.time_usec, entry.at_ns});
  }
  align_control_stamps(record);
}

void align_control_stamps(RunRecord& record) {
  constexpr std::int64_t kEcho_us = 1'000'000;  // nearer than this a stamp is taken for an echo
  const auto first = std::ranges::find_if(record.controller, is_control);
  if (first == record.controller.end()) return;
  const std::int64_t offset =
      sensor_stamp_at(record.simulator, first->at_ns) - static_cast<std::int64_t>(first->time_usec);
  if (std::abs(offset) < kEcho_us) return;
  record.foreign_stamps = true;
  for (auto* ledger : {&record.controller, &record.simulator}) {
    for (base::LedgerEntry& entry : *ledger) {
      if (is_control(entry)) entry.time_usec += static_cast<std::uint64_t>(offset);
    }
  }
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/fcu_probe.hpp"

#include <cctype>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/time/clock.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr base::Duration kHeartbeatPatience = seconds(10);
constexpr base::Duration kLook = milliseconds(200);
/// casd's rates are over the last seconds.
constexpr base::Duration kSettle = seconds(4);

void read_link(base::rpc::Client& casd, FcuFacts& facts) {
  const Json status = casd.call("casd.status", Json::object());
  for (const Json& link : status.value("links", Json::array())) {
    if (link.value("name", "") != "fcu") continue;
    facts.link_up = link.value("state", "") == "up";
    facts.link_words = link.value("endpoint", "");
    facts.crc_errors = link.value("rx", Json::object()).value("crc_errors", 0.0);
  }
}

void read_vehicle(base::rpc::Client& casd, FcuFacts& facts) {
  try {
    const Json state = casd.call("vehicle.state", Json::object());
    facts.heard = true;
    facts.hil = state.value("hil", false);
    facts.armed = state.value("armed", false);
    facts.autopilot = state.value("autopilot", "");
    for (char& c : facts.autopilot) {
      c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  } catch (const base::rpc::CallError& error) {
    if (error.code() != base::rpc::kNoSuchVehicle) throw;
  }
}

std::optional<double> read_param(base::rpc::Client& casd, const std::string& name) {
  try {
    return casd.call("param.get", {{"name", name}}).value("value", 0.0);
  } catch (const base::rpc::CallError&) {
    return std::nullopt;  // this firmware has none of that name
  }
}

void read_rates(base::rpc::Client& casd, FcuFacts& facts) {
  const Json answer = casd.call("message.list", {{"link", "fcu"}});
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

}  // namespace

FcuFacts probe_fcu(base::rpc::Client& casd, Supervisor& supervisor, const std::string& device) {
  FcuFacts facts{.device = device};
  const base::RunTime deadline = base::steady_now() + kHeartbeatPatience;
  while (!facts.heard && base::steady_now() < deadline) {
    read_link(casd, facts);
    read_vehicle(casd, facts);
    supervisor.wait(kLook);
  }
  if (!facts.heard) return facts;
  supervisor.wait(kSettle);
  read_link(casd, facts);
  read_vehicle(casd, facts);
  read_rates(casd, facts);
  if (facts.autopilot == "px4") facts.sys_hitl = read_param(casd, "SYS_HITL");
  return facts;
}

}  // namespace cas::hils

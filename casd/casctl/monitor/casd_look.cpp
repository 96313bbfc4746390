// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/casd_look.hpp"

#include <chrono>

namespace cas::casctl {

using base::rpc::CallError;
using nlohmann::json;

namespace {

/// The result, or null where this casd or this vehicle has none: the rest is shown.
json call_or_null(Session& session, const std::string& method, const json& params) {
  try {
    return session.call(method, params);
  } catch (const CallError&) {
    return nullptr;
  }
}

}  // namespace

double now_s() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

Look take_look(std::unique_ptr<Session>& session, const Options& options, Look look) {
  try {
    if (!session) session = std::make_unique<Session>(options);
    look.status = session->call("casd.status");
    look.messages = session->call("message.list", {{"limit", kMostRows}});
    const json vehicles = look.status.value("vehicles", json::array());
    if (!look.vehicle && !vehicles.empty()) look.vehicle = vehicles[0].value("system", 0);
    if (look.vehicle && !vehicles.empty()) {
      look.state = call_or_null(*session, "vehicle.state", {{"vehicle", *look.vehicle}});
      look.telemetry = call_or_null(*session, "vehicle.telemetry", {{"vehicle", *look.vehicle}});
    }
    if (look.open) {
      look.value = call_or_null(*session, "message.value",
                                {{"link", look.open->link},
                                 {"message", look.open->id},
                                 {"system", look.open->system},
                                 {"component", look.open->component}});
    }
  } catch (const std::exception& error) {
    session.reset();
    look.fault = error.what();
  }
  look.time_s = now_s();
  return look;
}

GainsAnswer ask_gains(const Options& options) {
  GainsAnswer answer;
  try {
    Session session(options);
    const json list = session.vehicle_call("gain.list");
    for (const json& loop : list.at("loops")) {
      answer.gains.push_back(session.vehicle_call("gain.get", {{"loop", loop.at("loop")}}));
    }
  } catch (const std::exception& error) {
    answer.fault = error.what();
  }
  return answer;
}

std::vector<std::string> ask_parameters(const Options& options) {
  std::vector<std::string> names;
  try {
    Session session(options);
    const json list = session.vehicle_call("param.list");
    for (const json& entry : list.at("parameters")) names.push_back(entry.at("name"));
  } catch (const std::exception&) {
  }
  return names;
}

CommandAnswer run_command(const Options& options, const std::string& line, const PromptCall& call) {
  try {
    Session session(options);
    const json result = call.of_vehicle ? session.vehicle_call(call.method, call.params)
                                        : session.call(call.method, call.params);
    std::string answer = line + ": " + answer_text(call, result);
    if (call.method == "vehicle.takeoff" &&
        !session.vehicle_call("vehicle.state").value("armed", false)) {
      answer += "; it takes off when it is armed, and was last heard disarmed";
    }
    return {answer, true};
  } catch (const std::exception& error) {
    return {line + ": " + error.what(), false};
  }
}

}  // namespace cas::casctl

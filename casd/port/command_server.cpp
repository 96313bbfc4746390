// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/command_server.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "casd/port/command_json.hpp"
#include "casd/port/command_params.hpp"

namespace cas::casd {
namespace {

using base::rpc::Reply;
using nlohmann::json;

int error_code(OutcomeKind kind) {
  switch (kind) {
    case OutcomeKind::kTimeout:
      return base::rpc::kTimeout;
    case OutcomeKind::kNoSuchVehicle:
      return base::rpc::kNoSuchVehicle;
    case OutcomeKind::kInterlock:
      return base::rpc::kInterlock;
    case OutcomeKind::kInvalid:
      return base::rpc::kInvalidParams;
    case OutcomeKind::kAccepted:
    case OutcomeKind::kRefused:
      break;
  }
  return base::rpc::kRefused;
}

json error_data(const Outcome& outcome) {
  json data{{"status_texts", outcome.status_texts}};
  if (outcome.result) {
    data["result"] = result_word(*outcome.result);
    data["result_code"] = static_cast<unsigned>(*outcome.result);
  }
  if (!outcome.parameters.empty()) data["parameters"] = parameters_json(outcome.parameters);
  return data;
}

void answer_error(const Reply& reply, const Outcome& outcome) {
  reply.error(error_code(outcome.kind), outcome.message, error_data(outcome));
}

}  // namespace

CommandServer::CommandServer(base::rpc::Server& server, VehicleCommander& commander, GainMap gains,
                             CommandServerHooks hooks)
    : server_(server), commander_(commander), gains_(std::move(gains)), hooks_(std::move(hooks)) {
  add_flight_methods();
  add_raw_methods();
  add_state_methods();
  add_gain_methods();
  add_param_methods();
  server_.add_topic("statustext");
  commander_.on_text(
      [this](const VehicleState& vehicle, const StatusText& text) { publish_text(vehicle, text); });
}

void CommandServer::add(const std::string& name, bool audited, Parse parse, Answer answer) {
  server_.add_method(name, [this, name, audited, parse = std::move(parse),
                            answer = std::move(answer)](const json& params, Reply reply) {
    run(name, audited, parse, answer, params, reply);
  });
}

void CommandServer::run(const std::string& name, bool audited, const Parse& parse,
                        const Answer& answer, const json& params, const Reply& reply) {
  Action action;
  std::optional<std::uint8_t> asked;
  try {
    CommandParams reader(params);
    if (const auto vehicle = reader.optional_integer("vehicle", 1, 255)) {
      asked = static_cast<std::uint8_t>(*vehicle);
    }
    action = parse(reader);
    reader.finish();
  } catch (const BadParams& error) {
    reply.error(base::rpc::kInvalidParams, error.what(), nullptr);
    return;
  }
  const auto resolved = commander_.resolve(asked);
  if (const auto* why = std::get_if<Outcome>(&resolved)) {
    if (audited) audit(reply.client, name, params, asked.value_or(0), *why);
    answer_error(reply, *why);
    return;
  }
  const std::uint8_t system = std::get<std::uint8_t>(resolved);
  const base::RunTime now = hooks_.now();
  const bool logged = audited && !is_more_of_sticks(name, now);
  action(system, now,
         [this, name, audited = logged, answer, params, reply, system](const Outcome& outcome) {
           if (audited) audit(reply.client, name, params, system, outcome);
           if (outcome.ok()) {
             reply.result(answer(system, outcome));
           } else {
             answer_error(reply, outcome);
           }
         });
}

bool CommandServer::is_more_of_sticks(const std::string& name, base::RunTime now) {
  constexpr auto kStretch = std::chrono::seconds(1);
  if (name != "vehicle.manual_control") return false;
  const auto before = std::exchange(last_sticks_, now);
  return before && now - *before < kStretch;
}

/// "127.0.0.1:40412 vehicle.takeoff {"altitude_m":2.5} vehicle 1: accepted".
void CommandServer::audit(const std::string& client, const std::string& name, const json& params,
                          std::uint8_t system, const Outcome& outcome) const {
  if (!hooks_.audit) return;
  const std::string asked =
      params.is_null() ? "{}" : params.dump(-1, ' ', false, json::error_handler_t::replace);
  hooks_.audit(client + " " + name + " " + asked + " vehicle " + std::to_string(system) + ": " +
               (outcome.ok() ? "accepted" : outcome.message));
}

void CommandServer::publish_text(const VehicleState& vehicle, const StatusText& text) {
  server_.publish("statustext", json{{"vehicle", vehicle.source().system},
                                     {"severity", severity_word(text.severity)},
                                     {"text", text.text}});
}

}  // namespace cas::casd

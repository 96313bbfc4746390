// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/vehicle_methods.hpp"

#include <fmt/format.h>
#include <array>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "casd/port/call_json.hpp"
#include "casd/port/telemetry_json.hpp"
#include "casd/port/vehicle_json.hpp"

namespace cas::casd {
namespace {

using base::RunTime;
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

/// Period for SET_MESSAGE_INTERVAL: `hz` above 0, 0 for off, absent for the vehicle's default.
double period_us(CallParams& params) {
  const std::optional<double> hz = params.optional_number("hz");
  if (!hz) return 0;
  if (*hz < 0 || *hz > 10000) throw BadParams("\"hz\" must be from 0 (off) to 10000");
  return *hz == 0 ? -1 : 1e6 / *hz;
}

/// Seven numbers; null is NaN.
std::array<float, 7> command_numbers(const json& list) {
  std::array<float, 7> numbers{};
  if (list.is_null()) return numbers;
  if (!list.is_array() || list.size() > numbers.size()) {
    throw BadParams("\"params\" must be a list of at most 7 numbers");
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].is_null()) {
      numbers[i] = std::numeric_limits<float>::quiet_NaN();
    } else if (list[i].is_number()) {
      numbers[i] = list[i].get<float>();
    } else {
      throw BadParams("\"params\" must hold numbers or null (NaN)");
    }
  }
  return numbers;
}

VehicleCommander::Sticks sticks_of(CallParams& params) {
  const auto stick = [&params](const std::string& key, double low) {
    const double value = params.optional_number(key).value_or(0);
    if (!(value >= low && value <= 1)) {
      throw BadParams("\"" + key + "\" must be from " + (low < 0 ? "-1" : "0") + " to 1");
    }
    return value;
  };
  return {.pitch = stick("pitch", -1),
          .roll = stick("roll", -1),
          .throttle = stick("throttle", 0),
          .yaw = stick("yaw", -1),
          .buttons = static_cast<std::uint16_t>(
              params.optional_integer("buttons", 0, 0xffff).value_or(0))};
}

std::string loop_words(const std::vector<GainLoop>& loops) {
  return base::joined(loops, " ", &GainLoop::name);
}

std::vector<std::string_view> loop_names(const std::vector<GainLoop>& loops) {
  std::vector<std::string_view> names;
  names.reserve(loops.size());
  for (const GainLoop& loop : loops) names.push_back(loop.name);
  return names;
}

json loop_json(const GainLoop& loop) {
  json entry{{"loop", loop.name}, {"parameters", json::object()}};
  if (loop.p) entry["parameters"]["p"] = *loop.p;
  if (loop.i) entry["parameters"]["i"] = *loop.i;
  if (loop.d) entry["parameters"]["d"] = *loop.d;
  return entry;
}

GainValues gains_to_set(CallParams& reader) {
  const GainValues values{reader.optional_number("p"), reader.optional_number("i"),
                          reader.optional_number("d")};
  if (!values.p && !values.i && !values.d) throw BadParams("give \"p\", \"i\" or \"d\"");
  return values;
}

/// {vehicle, loop, p, i, d in force, parameters: {NAME: value}, before: {p, i, d that were set}}.
json gains_json(std::uint8_t system, const GainLoop& loop, const Outcome& outcome) {
  json answer{{"vehicle", system},
              {"loop", loop.name},
              {"parameters", parameters_json(outcome.parameters)}};
  const auto put = [&](const char* key, const std::optional<std::string>& name) {
    if (!name) return;
    if (outcome.parameters.contains(*name)) {
      answer[key] = number_json(outcome.parameters.at(*name));
    }
    if (outcome.before.contains(*name)) {
      answer["before"][key] = number_json(outcome.before.at(*name));
    }
  };
  put("p", loop.p);
  put("i", loop.i);
  put("d", loop.d);
  return answer;
}

}  // namespace

VehicleMethods::VehicleMethods(base::rpc::Server& server, VehicleCommander& commander,
                               GainMap gains, VehicleHooks hooks)
    : server_(server), commander_(commander), gains_(std::move(gains)), hooks_(std::move(hooks)) {
  add_arming_methods();
  add_flight_methods();
  add_raw_methods();
  add_state_methods();
  add_gain_methods();
  add_param_methods();
  add_journal_method();
  server_.add_topic("statustext");
  server_.add_topic("parameters");
  commander_.on_text(
      [this](const VehicleState& vehicle, const StatusText& text) { publish_text(vehicle, text); });
}

void VehicleMethods::add(const std::string& name, bool audited, Parse parse, Answer answer) {
  server_.add_method(
      name,
      [this, name, audited, parse = std::move(parse), answer = std::move(answer)](
          const json& params, Reply reply) { run(name, audited, parse, answer, params, reply); },
      audited ? kWeightOfChange : 1);
}

void VehicleMethods::add_command(const std::string& name, Parse parse) {
  add(name, true, std::move(parse), [this](std::uint8_t system, const Outcome&) {
    return json{{"vehicle", system}, {"result", "ACCEPTED"}, {"at_s", moment_s(hooks_.now())}};
  });
}

void VehicleMethods::add_look(const std::string& name,
                              std::function<json(const VehicleState&)> look) {
  add(
      name, false,
      [](CallParams&) { return [](std::uint8_t, RunTime, const Done& done) { done(Outcome{}); }; },
      [this, look = std::move(look)](std::uint8_t system, const Outcome&) {
        const VehicleState* const vehicle = commander_.find(system);
        return vehicle == nullptr ? json() : look(*vehicle);
      });
}

void VehicleMethods::run(const std::string& name, bool audited, const Parse& parse,
                         const Answer& answer, const json& params, const Reply& reply) {
  std::optional<std::uint8_t> asked;
  CallParams reader(params);
  if (const auto vehicle = reader.optional_integer("vehicle", 1, 255)) {
    asked = static_cast<std::uint8_t>(*vehicle);
  }
  const Action action = parse(reader);
  reader.finish();
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

bool VehicleMethods::is_more_of_sticks(const std::string& name, base::RunTime now) {
  constexpr auto kStretch = std::chrono::seconds(1);
  if (name != "vehicle.manual_control") return false;
  const auto before = std::exchange(last_sticks_, now);
  return before && now - *before < kStretch;
}

/// "127.0.0.1:40412 vehicle.takeoff {"altitude_m":2.5} vehicle 1: accepted". Clients repeat a call
/// until a vehicle can arm: the same refusal leaves one line a minute.
void VehicleMethods::audit(const std::string& client, const std::string& name, const json& params,
                           std::uint8_t system, const Outcome& outcome) {
  constexpr auto kStretch = std::chrono::minutes(1);
  if (!hooks_.audit) return;
  const base::RunTime now = hooks_.now();
  const std::string asked =
      params.is_null() ? "{}" : params.dump(-1, ' ', false, json::error_handler_t::replace);
  const std::string whom = system == 0 ? "" : fmt::format(" vehicle {}", system);
  const std::string line = fmt::format("{} {} {}{}: {}", client, name, asked, whom,
                                       outcome.ok() ? "accepted" : outcome.message);
  if (line == last_refusal_ && now - refused_at_ < kStretch) {
    ++refused_again_;
    journal_.again();
    return;
  }
  const std::uint64_t again = std::exchange(refused_again_, 0);
  if (again > 0) hooks_.audit(fmt::format("(the same again {} times)", again));
  last_refusal_ = outcome.ok() ? "" : line;
  refused_at_ = now;
  hooks_.audit(line);
  journal_.add({.at = now,
                .unix_us = hooks_.unix_us ? hooks_.unix_us() : 0,
                .client = client,
                .method = name,
                .params = asked,
                .system = system,
                .refusal = outcome.ok() ? std::nullopt : std::optional(outcome.message)});
}

void VehicleMethods::audit_other(const std::string& client, const std::string& name,
                                 const json& params, const std::optional<std::string>& refusal) {
  audit(client, name, params, 0, refusal ? failure(OutcomeKind::kInvalid, *refusal) : Outcome{});
}

void VehicleMethods::publish() {
  if (!server_.has_subscribers("parameters")) return;
  for (const VehicleState* vehicle : commander_.vehicles()) {
    const std::uint8_t system = vehicle->source().system;
    const auto progress = commander_.list_progress(system);
    if (!progress) continue;
    server_.publish(
        "parameters",
        json{{"vehicle", system}, {"received", progress->received}, {"count", progress->count}});
  }
}

void VehicleMethods::publish_text(const VehicleState& vehicle, const StatusText& text) {
  server_.publish("statustext", json{{"vehicle", vehicle.source().system},
                                     {"severity", severity_word(text.severity)},
                                     {"text", text.text}});
}

/// Calls a method of the commander with these arguments between vehicle and time.
template <class... Args>
VehicleMethods::Action VehicleMethods::calls(auto verb, Args... args) {
  return [this, verb, args...](std::uint8_t system, RunTime now, Done done) {
    (commander_.*verb)(system, args..., now, std::move(done));
  };
}

/// The same for what may move a vehicle: `not_hil` of the call consents to one that is not in HIL.
template <class... Args>
VehicleMethods::Action VehicleMethods::moves(CallParams& params, auto verb, Args... args) {
  const bool not_hil = params.flag("not_hil");
  return [this, not_hil, verb, args...](std::uint8_t system, RunTime now, Done done) {
    (commander_.*verb)(system, args..., now, std::move(done), not_hil);
  };
}

void VehicleMethods::add_arming_methods() {
  add_command("vehicle.arm", [this](CallParams& params) {
    const VehicleCommander::ArmOptions options{.force = params.flag("force"),
                                               .not_hil = params.flag("not_hil")};
    return calls(&VehicleCommander::arm, options);
  });
  add_command("vehicle.disarm", [this](CallParams& params) {
    return calls(&VehicleCommander::disarm, params.flag("force"));
  });
}

void VehicleMethods::add_flight_methods() {
  add_command("vehicle.takeoff", [this](CallParams& params) {
    const double altitude_m = params.number("altitude_m");
    if (!(altitude_m > 0)) throw BadParams("\"altitude_m\" must be above 0");
    return moves(params, &VehicleCommander::takeoff, altitude_m);
  });
  const auto add_plain = [this](const std::string& name, auto verb) {
    add_command(name, [this, verb](CallParams&) { return calls(verb); });
  };
  add_plain("vehicle.land", &VehicleCommander::land);
  add_plain("vehicle.hold", &VehicleCommander::hold);
  add_plain("vehicle.rtl", &VehicleCommander::return_home);
  add_command("vehicle.reboot",
              [this](CallParams& params) { return moves(params, &VehicleCommander::reboot); });
  add_command("vehicle.goto", [this](CallParams& params) {
    const VehicleCommander::Target target{
        params.number("north_m"), params.number("east_m"), params.number("down_m"),
        params.optional_number("yaw_deg"), params.optional_number("radius_m")};
    return moves(params, &VehicleCommander::go_to, target);
  });
  add_command("vehicle.mode", [this](CallParams& params) {
    return moves(params, &VehicleCommander::set_mode, params.text("mode"));
  });
}

void VehicleMethods::add_raw_methods() {
  add(
      "vehicle.manual_control", true,
      [this](CallParams& params) {
        const VehicleCommander::Sticks sticks = sticks_of(params);
        return calls(&VehicleCommander::manual_control, sticks, params.flag("not_hil"));
      },
      [](std::uint8_t system, const Outcome&) {
        return json{{"vehicle", system}, {"result", "SENT"}};
      });
  add_command("vehicle.message_interval", [this](CallParams& params) {
    const std::uint32_t id = message_id(params.value("message"));
    return calls(&VehicleCommander::message_interval, id, period_us(params));
  });
  add_command("vehicle.command", [this](CallParams& params) {
    VehicleCommand command;
    command.id = static_cast<mavlink::common::MavCmd>(params.integer("command", 0, 0xffff));
    command.params = command_numbers(params.value("params"));
    return calls(&VehicleCommander::command, command, params.flag("not_hil"));
  });
}

json VehicleMethods::vehicles() const {
  json all = json::array();
  for (const VehicleState* vehicle : commander_.vehicles()) {
    all.push_back(summary_json(*vehicle, hooks_.link_name, hooks_.now()));
  }
  return all;
}

void VehicleMethods::add_state_methods() {
  add_look("vehicle.state", [this](const VehicleState& vehicle) {
    const base::RunTime now = hooks_.now();
    json state = state_json(vehicle, hooks_.link_name, now);
    const Hands& hands = commander_.hands(vehicle.source().system);
    json others = interventions_json(hands.interventions, hooks_.link_name, now);
    if (!others.empty()) state["interventions"] = std::move(others);
    return state;
  });
  add_look("vehicle.telemetry",
           [this](const VehicleState& vehicle) { return telemetry_json(vehicle, hooks_.now()); });
}

/// The loop's parameters on this vehicle; if there is no such loop, answers `done` with those that
/// there are.
const GainLoop* VehicleMethods::find_loop(std::uint8_t system, const std::string& loop,
                                          const Done& done) const {
  const VehicleState* vehicle = commander_.find(system);
  const Autopilot autopilot = vehicle == nullptr ? Autopilot::kOther : vehicle->autopilot();
  if (const GainLoop* found = gains_.find(autopilot, loop)) return found;
  const std::string who = std::string(name(autopilot));
  if (gains_.loops(autopilot).empty()) {
    done(failure(OutcomeKind::kRefused, "casd has no gain map for autopilot " + who +
                                            "; name a file under `gains` in its topology"));
  } else {
    done(failure(OutcomeKind::kRefused,
                 "there is no loop '" + loop + "' for " + who + "; it has " +
                     loop_words(gains_.loops(autopilot)) +
                     base::did_you_mean(loop, loop_names(gains_.loops(autopilot)))));
  }
  return nullptr;
}

void VehicleMethods::add_gain_methods() {
  add_loop_method("gain.set", true, gains_to_set);
  add_loop_method("gain.get", false, [](CallParams&) { return GainValues{}; });
  add_look("gain.list", [this](const VehicleState& vehicle) {
    json loops = json::array();
    for (const GainLoop& loop : gains_.loops(vehicle.autopilot())) loops.push_back(loop_json(loop));
    return json{{"vehicle", vehicle.source().system}, {"loops", loops}};
  });
}

/// A method on one control loop. The request passes the loop that it found on to the answer.
void VehicleMethods::add_loop_method(const std::string& name, bool audited,
                                     std::function<GainValues(CallParams&)> values_of) {
  server_.add_method(
      name,
      [this, name, audited, values_of](const json& params, Reply reply) {
        const auto loop = std::make_shared<GainLoop>();
        const Parse parse = [this, audited, loop, values_of](CallParams& reader) -> Action {
          const std::string word = reader.text("loop");
          const GainValues values = values_of(reader);
          const bool not_hil = audited && reader.flag("not_hil");
          return [this, word, values, not_hil, loop](std::uint8_t system, RunTime now, Done done) {
            const GainLoop* found = find_loop(system, word, done);
            if (found == nullptr) return;
            *loop = *found;
            commander_.set_gains(system, *found, values, now, std::move(done), not_hil);
          };
        };
        const Answer answer = [loop](std::uint8_t system, const Outcome& outcome) {
          return gains_json(system, *loop, outcome);
        };
        run(name, audited, parse, answer, params, reply);
      },
      audited ? kWeightOfChange : 1);
}

void VehicleMethods::add_journal_method() {
  casd::add_look(server_, "casd.journal", [this](CallParams& params) {
    params.finish();
    return journal_.answer();
  });
}

void VehicleMethods::add_param_methods() {
  const auto entry = [this](std::uint8_t system, const std::string& param, double value) {
    const auto type = commander_.param_type(system, param);
    return json{{"name", param},
                {"value", number_json(value)},
                {"type", type ? name(*type) : std::string_view("unknown")}};
  };
  const auto one = [entry](std::uint8_t system, const Outcome& outcome) {
    const auto& [param, value] = *outcome.parameters.begin();
    json answer = entry(system, param, value);
    answer["vehicle"] = system;
    if (outcome.before.contains(param)) answer["before"] = number_json(outcome.before.at(param));
    return answer;
  };
  add(
      "param.get", false,
      [this](CallParams& params) {
        return calls(&VehicleCommander::read_param, params.text("name"));
      },
      one);
  add(
      "param.set", true,
      [this](CallParams& params) {
        const double value = params.number("value");
        return moves(params, &VehicleCommander::set_param, params.text("name"), value);
      },
      one);
  add(
      "param.list", false, [this](CallParams&) { return calls(&VehicleCommander::list_params); },
      [entry](std::uint8_t system, const Outcome& outcome) {
        json list = json::array();
        for (const auto& [param, value] : outcome.parameters) {
          list.push_back(entry(system, param, value));
        }
        return json{{"vehicle", system}, {"parameters", list}};
      });
}

}  // namespace cas::casd

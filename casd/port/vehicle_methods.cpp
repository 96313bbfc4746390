// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/vehicle_methods.hpp"

#include <array>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/suggestion.hpp"
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

/// Seven numbers; null stands for NaN.
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

std::string loop_words(const std::vector<GainLoop>& loops) {
  std::string words;
  for (const GainLoop& loop : loops) words += (words.empty() ? "" : " ") + loop.name;
  return words;
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

/// The vehicle acknowledged a command now.
VehicleMethods::Answer VehicleMethods::accepted() const {
  return [this](std::uint8_t system, const Outcome&) {
    return json{{"vehicle", system}, {"result", "ACCEPTED"}, {"at_s", moment_s(hooks_.now())}};
  };
}

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

void VehicleMethods::run(const std::string& name, bool audited, const Parse& parse,
                         const Answer& answer, const json& params, const Reply& reply) {
  Action action;
  std::optional<std::uint8_t> asked;
  const auto fault = answer_call(params, reply, [&](CallParams& reader) {
    if (const auto vehicle = reader.optional_integer("vehicle", 1, 255)) {
      asked = static_cast<std::uint8_t>(*vehicle);
    }
    action = parse(reader);
    reader.finish();
  });
  if (fault) return;
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

/// "127.0.0.1:40412 vehicle.takeoff {"altitude_m":2.5} vehicle 1: accepted". Who waits until a
/// vehicle can arm asks again and again: the same refusal leaves one line in a minute.
void VehicleMethods::audit(const std::string& client, const std::string& name, const json& params,
                           std::uint8_t system, const Outcome& outcome) {
  constexpr auto kStretch = std::chrono::minutes(1);
  if (!hooks_.audit) return;
  const base::RunTime now = hooks_.now();
  const std::string asked =
      params.is_null() ? "{}" : params.dump(-1, ' ', false, json::error_handler_t::replace);
  const std::string whom = system == 0 ? "" : " vehicle " + std::to_string(system);
  const std::string line = client + " " + name + " " + asked + whom + ": " +
                           (outcome.ok() ? "accepted" : outcome.message);
  if (line == last_refusal_ && now - refused_at_ < kStretch) {
    ++refused_again_;
    journal_.again();
    return;
  }
  const std::uint64_t again = std::exchange(refused_again_, 0);
  if (again > 0) hooks_.audit("(the same again " + std::to_string(again) + " times)");
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

void VehicleMethods::publish_text(const VehicleState& vehicle, const StatusText& text) {
  server_.publish("statustext", json{{"vehicle", vehicle.source().system},
                                     {"severity", severity_word(text.severity)},
                                     {"text", text.text}});
}

void VehicleMethods::add_arming_methods() {
  add(
      "vehicle.arm", true,
      [this](CallParams& params) -> Action {
        VehicleCommander::ArmOptions options{.force = params.flag("force"),
                                             .not_hil = params.flag("not_hil")};
        options.acts_so_far =
            params.optional_integer("acts_so_far", 0, std::numeric_limits<std::int64_t>::max());
        return [this, options](std::uint8_t system, RunTime now, Done done) {
          commander_.arm(system, options, now, std::move(done));
        };
      },
      accepted());
  add(
      "vehicle.disarm", true,
      [this](CallParams& params) -> Action {
        return [this, force = params.flag("force")](std::uint8_t system, RunTime now, Done done) {
          commander_.disarm(system, force, now, std::move(done));
        };
      },
      accepted());
}

void VehicleMethods::add_flight_methods() {
  add(
      "vehicle.takeoff", true,
      [this](CallParams& params) -> Action {
        const double altitude_m = params.number("altitude_m");
        if (!(altitude_m > 0)) throw BadParams("\"altitude_m\" must be above 0");
        return [this, altitude_m](std::uint8_t system, RunTime now, Done done) {
          commander_.takeoff(system, altitude_m, now, std::move(done));
        };
      },
      accepted());
  const auto plain = [this](const std::string& name,
                            void (VehicleCommander::*verb)(std::uint8_t, RunTime, Done)) {
    add(
        name, true,
        [this, verb](CallParams&) -> Action {
          return [this, verb](std::uint8_t system, RunTime now, Done done) {
            (commander_.*verb)(system, now, std::move(done));
          };
        },
        accepted());
  };
  plain("vehicle.land", &VehicleCommander::land);
  plain("vehicle.hold", &VehicleCommander::hold);
  plain("vehicle.rtl", &VehicleCommander::return_home);
  plain("vehicle.reboot", &VehicleCommander::reboot);
  add(
      "vehicle.goto", true,
      [this](CallParams& params) -> Action {
        const VehicleCommander::Target target{params.number("north_m"), params.number("east_m"),
                                              params.number("down_m"),
                                              params.optional_number("yaw_deg")};
        return [this, target](std::uint8_t system, RunTime now, Done done) {
          commander_.go_to(system, target, now, std::move(done));
        };
      },
      accepted());
  add(
      "vehicle.mode", true,
      [this](CallParams& params) -> Action {
        return [this, mode = params.text("mode")](std::uint8_t system, RunTime now, Done done) {
          commander_.set_mode(system, mode, now, std::move(done));
        };
      },
      accepted());
}

void VehicleMethods::add_raw_methods() {
  add(
      "vehicle.manual_control", true,
      [this](CallParams& params) -> Action {
        const auto stick = [&params](const std::string& key, double low) {
          const double value = params.optional_number(key).value_or(0);
          if (!(value >= low && value <= 1)) {
            throw BadParams("\"" + key + "\" must be from " + (low < 0 ? "-1" : "0") + " to 1");
          }
          return value;
        };
        const VehicleCommander::Sticks sticks{
            .pitch = stick("pitch", -1),
            .roll = stick("roll", -1),
            .throttle = stick("throttle", 0),
            .yaw = stick("yaw", -1),
            .buttons = static_cast<std::uint16_t>(
                params.optional_integer("buttons", 0, 0xffff).value_or(0))};
        const bool not_hil = params.flag("not_hil");
        return [this, sticks, not_hil](std::uint8_t system, RunTime now, Done done) {
          commander_.manual_control(system, sticks, not_hil, now, std::move(done));
        };
      },
      [](std::uint8_t system, const Outcome&) {
        return json{{"vehicle", system}, {"result", "SENT"}};
      });
  add(
      "vehicle.message_interval", true,
      [this](CallParams& params) -> Action {
        const std::uint32_t id = message_id(params.value("message"));
        return [this, id, period = period_us(params)](std::uint8_t system, RunTime now, Done done) {
          commander_.message_interval(system, id, period, now, std::move(done));
        };
      },
      accepted());
  add(
      "vehicle.command", true,
      [this](CallParams& params) -> Action {
        VehicleCommand command;
        command.id = static_cast<mavlink::common::MavCmd>(params.integer("command", 0, 0xffff));
        command.params = command_numbers(params.value("params"));
        const bool not_hil = params.flag("not_hil");
        return [this, command, not_hil](std::uint8_t system, RunTime now, Done done) {
          commander_.command(system, command, not_hil, now, std::move(done));
        };
      },
      accepted());
}

json VehicleMethods::vehicles() const {
  json all = json::array();
  for (const VehicleState* vehicle : commander_.vehicles()) {
    all.push_back(summary_json(*vehicle, hooks_.link_name, hooks_.now()));
  }
  return all;
}

void VehicleMethods::add_state_methods() {
  add(
      "vehicle.state", false,
      [](CallParams&) -> Action {
        return [](std::uint8_t, base::RunTime, const Done& done) { done(Outcome{}); };
      },
      [this](std::uint8_t system, const Outcome&) {
        const VehicleState* vehicle = commander_.find(system);
        if (vehicle == nullptr) return json();
        const base::RunTime now = hooks_.now();
        json state = state_json(*vehicle, hooks_.link_name, now);
        const Hands& hands = commander_.hands(system);
        state["acts_so_far"] = hands.acts_so_far();
        json others = interventions_json(hands.interventions, hooks_.link_name, now);
        if (!others.empty()) state["interventions"] = std::move(others);
        return state;
      });
  add(
      "vehicle.telemetry", false,
      [](CallParams&) -> Action {
        return [](std::uint8_t, base::RunTime, const Done& done) { done(Outcome{}); };
      },
      [this](std::uint8_t system, const Outcome&) {
        const VehicleState* vehicle = commander_.find(system);
        if (vehicle == nullptr) return json();
        return telemetry_json(*vehicle, hooks_.now());
      });
}

/// The loop's parameters on this vehicle; otherwise answers `done` with what there is.
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
  add(
      "gain.list", false,
      [](CallParams&) -> Action {
        return [](std::uint8_t, RunTime, const Done& done) { done(Outcome{}); };
      },
      [this](std::uint8_t system, const Outcome&) {
        json loops = json::array();
        const VehicleState* vehicle = commander_.find(system);
        for (const GainLoop& loop : gains_.loops(vehicle->autopilot())) {
          loops.push_back(loop_json(loop));
        }
        return json{{"vehicle", system}, {"loops", loops}};
      });
}

/// A method on one control loop; the loop that was found travels from the request to the answer.
void VehicleMethods::add_loop_method(const std::string& name, bool audited,
                                     std::function<GainValues(CallParams&)> values_of) {
  server_.add_method(
      name,
      [this, name, audited, values_of](const json& params, Reply reply) {
        const auto loop = std::make_shared<GainLoop>();
        const Parse parse = [this, loop, values_of](CallParams& reader) -> Action {
          const std::string word = reader.text("loop");
          const GainValues values = values_of(reader);
          return [this, word, values, loop](std::uint8_t system, RunTime now, Done done) {
            const GainLoop* found = find_loop(system, word, done);
            if (found == nullptr) return;
            *loop = *found;
            commander_.set_gains(system, *found, values, now, std::move(done));
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
  server_.add_method("casd.journal", [this](const json& params, const Reply& reply) {
    try {
      CallParams(params).finish();
    } catch (const BadParams& error) {
      return reply.error(base::rpc::kInvalidParams, error.what(), nullptr);
    }
    reply.result(journal_.answer());
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
      [this](CallParams& params) -> Action {
        return [this, param = params.text("name")](std::uint8_t system, RunTime now, Done done) {
          commander_.read_param(system, param, now, std::move(done));
        };
      },
      one);
  add(
      "param.set", true,
      [this](CallParams& params) -> Action {
        const double value = params.number("value");
        return [this, value, param = params.text("name")](std::uint8_t system, RunTime now,
                                                          Done done) {
          commander_.set_param(system, param, value, now, std::move(done));
        };
      },
      one);
  add(
      "param.list", false,
      [this](CallParams&) -> Action {
        return [this](std::uint8_t system, RunTime now, Done done) {
          commander_.list_params(system, now, std::move(done));
        };
      },
      [entry](std::uint8_t system, const Outcome& outcome) {
        json list = json::array();
        for (const auto& [param, value] : outcome.parameters) {
          list.push_back(entry(system, param, value));
        }
        return json{{"vehicle", system}, {"parameters", list}};
      });
}

}  // namespace cas::casd

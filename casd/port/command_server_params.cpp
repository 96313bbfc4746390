// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>
#include <utility>

#include "casd/port/command_json.hpp"
#include "casd/port/command_params.hpp"
#include "casd/port/command_server.hpp"

namespace cas::casd {
namespace {

using base::RunTime;
using nlohmann::json;

std::string loop_words(const std::vector<GainLoop>& loops) {
  std::string words;
  for (const GainLoop& loop : loops) words += (words.empty() ? "" : " ") + loop.name;
  return words;
}

json loop_json(const GainLoop& loop) {
  json entry{{"loop", loop.name}, {"parameters", json::object()}};
  if (loop.p) entry["parameters"]["p"] = *loop.p;
  if (loop.i) entry["parameters"]["i"] = *loop.i;
  if (loop.d) entry["parameters"]["d"] = *loop.d;
  return entry;
}

/// {vehicle, loop, p, i, d in force, parameters: {NAME: value}}.
json gains_json(std::uint8_t system, const GainLoop& loop, const Outcome& outcome) {
  json answer{{"vehicle", system},
              {"loop", loop.name},
              {"parameters", parameters_json(outcome.parameters)}};
  const auto put = [&](const char* key, const std::optional<std::string>& name) {
    if (name && outcome.parameters.contains(*name)) {
      answer[key] = number_json(outcome.parameters.at(*name));
    }
  };
  put("p", loop.p);
  put("i", loop.i);
  put("d", loop.d);
  return answer;
}

}  // namespace

/// The loop's parameters on this vehicle; otherwise answers `done` with what there is.
const GainLoop* CommandServer::find_loop(std::uint8_t system, const std::string& loop,
                                         const Done& done) const {
  const VehicleState* vehicle = commander_.find(system);
  const Autopilot autopilot = vehicle == nullptr ? Autopilot::kOther : vehicle->autopilot();
  if (const GainLoop* found = gains_.find(autopilot, loop)) return found;
  const std::string who = std::string(name(autopilot));
  if (gains_.loops(autopilot).empty()) {
    done(failure(OutcomeKind::kRefused, "casd has no gain map for autopilot " + who +
                                        "; name a file under `gains` in its topology"));
  } else {
    done(failure(OutcomeKind::kRefused, "there is no loop '" + loop + "' for " + who + "; it has " +
                                        loop_words(gains_.loops(autopilot))));
  }
  return nullptr;
}

void CommandServer::add_gain_methods() {
  const auto add_loop_method = [this](const std::string& name, bool sets) {
    // The loop that was found travels from the request to the answer.
    server_.add_method(name, [this, name, sets](const json& params, base::rpc::Reply reply) {
      const auto loop = std::make_shared<GainLoop>();
      run(
          name, sets,
          [this, sets, loop](CommandParams& reader) -> Action {
            const std::string word = reader.text("loop");
            GainValues values;
            if (sets) {
              values = {reader.optional_number("p"), reader.optional_number("i"),
                        reader.optional_number("d")};
              if (!values.p && !values.i && !values.d)
                throw BadParams("give \"p\", \"i\" or \"d\"");
            }
            return [this, word, values, loop](std::uint8_t system, RunTime now, Done done) {
              const GainLoop* found = find_loop(system, word, done);
              if (found == nullptr) return;
              *loop = *found;
              commander_.set_gains(system, *found, values, now, std::move(done));
            };
          },
          [loop](std::uint8_t system, const Outcome& outcome) {
            return gains_json(system, *loop, outcome);
          },
          params, reply);
    });
  };
  add_loop_method("gain.set", true);
  add_loop_method("gain.get", false);
  add(
      "gain.list", false,
      [](CommandParams&) -> Action {
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

void CommandServer::add_param_methods() {
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
    return answer;
  };
  add(
      "param.get", false,
      [this](CommandParams& params) -> Action {
        return [this, param = params.text("name")](std::uint8_t system, RunTime now, Done done) {
          commander_.read_param(system, param, now, std::move(done));
        };
      },
      one);
  add(
      "param.set", true,
      [this](CommandParams& params) -> Action {
        const double value = params.number("value");
        return [this, value, param = params.text("name")](std::uint8_t system, RunTime now,
                                                          Done done) {
          commander_.set_param(system, param, value, now, std::move(done));
        };
      },
      one);
  add(
      "param.list", false,
      [this](CommandParams&) -> Action {
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

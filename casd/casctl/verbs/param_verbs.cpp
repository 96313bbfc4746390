// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "base/os/write_file.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/param_load.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

void add_setgain(CommandLine& line) {
  struct Wish {
    std::string loop;
    std::vector<double> values;
    std::optional<double> p, i, d;
  };
  const auto wish = std::make_shared<Wish>();
  CLI::App* const verb =
      line.add_verb("setgain", "Set PID gains of a control loop; prints those in force, old -> new",
                    "casctl setgain rollrate 0.15 0.2 0.003   or   casctl setgain roll --p 6.5",
                    [wish](Session& session) {
                      json params{{"loop", wish->loop}};
                      if (wish->values.size() > 0) wish->p = wish->values[0];
                      if (wish->values.size() > 1) wish->i = wish->values[1];
                      if (wish->values.size() > 2) wish->d = wish->values[2];
                      if (wish->p) params["p"] = *wish->p;
                      if (wish->i) params["i"] = *wish->i;
                      if (wish->d) params["d"] = *wish->d;
                      const json result = session.vehicle_call("gain.set", params);
                      report(session.options(), result, gains_text(result));
                      return kDone;
                    });
  verb->add_option("LOOP", wish->loop,
                   "One of rollrate, roll, position, ...: `casctl gains` lists them")
      ->required();
  CLI::Option* const values =
      verb->add_option("P I D", wish->values, "The three gains")->expected(0, 3);
  for (auto [flag, slot] : {std::pair{"--p", &wish->p}, {"--i", &wish->i}, {"--d", &wish->d}}) {
    verb->add_option(flag, *slot, "This gain only")->excludes(values);
  }
  verb->parse_complete_callback([wish] {
    std::vector<double> all = wish->values;
    for (const auto& value : {wish->p, wish->i, wish->d}) all.push_back(value.value_or(0));
    const auto finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(all, finite)) {
      throw CLI::ValidationError("setgain", "a gain is a finite number");
    }
    if (!wish->p && !wish->i && !wish->d && wish->values.empty()) {
      throw CLI::ValidationError("setgain", "give P I D, or --p, --i, --d");
    }
  });
}

/// The gains of one loop, or of all where none is named.
json fetch_gains(Session& session, const std::string& loop) {
  if (!loop.empty()) return json::array({session.vehicle_call("gain.get", {{"loop", loop}})});
  json all = json::array();
  const json list = session.vehicle_call("gain.list");
  for (const json& entry : list.at("loops")) {
    all.push_back(session.vehicle_call("gain.get", {{"loop", entry.at("loop")}}));
  }
  return all;
}

void print_gains(const json& all) {
  Table table({"LOOP", "P", "I", "D"});
  const auto cell = [](const json& gains, const char* key) {
    return gains.contains(key) ? gains[key].dump() : "-";
  };
  for (const json& gains : all) {
    table.add({gains.value("loop", "?"), cell(gains, "p"), cell(gains, "i"), cell(gains, "d")});
  }
  table.print(std::cout);
}

void add_gains(CommandLine& line) {
  const auto loop = std::make_shared<std::string>();
  line.add_verb("gains", "Show the gains of one loop, or of all", "casctl gains rollrate",
                [loop](Session& session) {
                  const json all = fetch_gains(session, *loop);
                  const json& asked = loop->empty() ? all : all.at(0);
                  if (!printed_as_json(session.options(), asked)) print_gains(all);
                  return kDone;
                })
      ->add_option("LOOP", *loop, "Control loop; left out: all");
}

/// ": A, B" of the parameters that a file cannot give back.
std::string names_text(const json& names) {
  std::string text;
  for (const json& name : names) text += (text.empty() ? ": " : ", ") + name.get<std::string>();
  return text;
}

/// The parameters of a vehicle: all, or those that came before it fell silent.
struct ParamList {
  int vehicle = 0;
  json parameters = json::array();            ///< {name, value, ...}
  std::optional<base::rpc::CallError> fault;  ///< why they are not all

  bool whole() const { return !fault.has_value(); }
};

/// @throws CallError  if none came
ParamList fetch_params(Session& session) {
  ParamList list;
  try {
    list.vehicle = session.vehicle_call("vehicle.state").at("system");
    list.parameters = session.list_params(list.vehicle).at("parameters");
  } catch (const base::rpc::CallError& error) {
    const json data = json::parse(error.data_json(), nullptr, false);
    const json came = data.is_object() ? data.value("parameters", json::object()) : json();
    if (came.empty()) throw;
    for (const auto& [name, value] : came.items()) {
      list.parameters.push_back({{"name", name}, {"value", value}});
    }
    list.fault = error;
  }
  return list;
}

/// Says why the list is not whole. @return the exit code
int end_of(const Session& session, const ParamList& list) {
  if (list.whole()) return kDone;
  if (!session.options().json) {
    std::cerr << "casctl: not all parameters came: " << printable_lines(list.fault->what()) << '\n';
  }
  return list.fault->code() == base::rpc::kTimeout ? kTimeout : kRefused;
}

/// Adds key `missing` to the result: why the list is not whole.
void add_fault(json& result, const ParamList& list) {
  if (!list.whole()) result["missing"] = list.fault->what();
}

int save_params(Session& session, const std::string& file) {
  const ParamList list = fetch_params(session);
  std::ostringstream out;
  json left_out = json::array();
  std::size_t saved = 0;
  out << "# Parameters of vehicle " << list.vehicle << ": NAME VALUE\n";
  if (!list.whole()) out << "# Not all of them: " << list.fault->what() << '\n';
  for (const json& entry : list.parameters) {
    const auto name = entry.at("name").get<std::string>();
    const json& value = entry.at("value");
    if (value.is_number()) {
      out << printable(name) << ' ' << value.dump() << '\n';
      ++saved;
    } else {  // casd answers null, and would not write such a value either
      out << "# " << printable(name) << " is NaN or infinite\n";
      left_out.push_back(name);
    }
  }
  base::write_file(file, out.view());
  std::string sentence = std::to_string(saved) + " parameters saved to " + file;
  if (!left_out.empty()) sentence += "; NaN or infinite, so left out" + names_text(left_out);
  json result{{"file", file}, {"saved", saved}, {"left_out", left_out}};
  add_fault(result, list);
  report(session.options(), result, sentence);
  return end_of(session, list);
}

int list_params(Session& session, const std::string& prefix) {
  const ParamList list = fetch_params(session);
  Table table({"NAME", "VALUE", "TYPE"});
  json kept = json::array();
  for (const json& entry : list.parameters) {
    const std::string name = entry.at("name");
    if (name.compare(0, prefix.size(), prefix) != 0) continue;
    table.add({name, entry.at("value").dump(), entry.value("type", "?")});
    kept.push_back(entry);
  }
  if (session.options().json) {
    json result{{"vehicle", list.vehicle}, {"parameters", kept}};
    add_fault(result, list);
    report(session.options(), result, "");
  } else {
    table.print(std::cout);
  }
  return end_of(session, list);
}

void add_consent(CLI::App* verb, bool& not_hil) {
  verb->add_flag("--not-hil", not_hil,
                 "Also one that arms or drives outputs, of a vehicle that does not say it is in "
                 "HIL: PROPELLERS MAY SPIN; casd's configuration must consent");
}

int print_param(const Session& session, const json& result) {
  report(session.options(), result, param_text(result));
  return kDone;
}

void add_param_load(CommandLine& line, CLI::App* param) {
  struct Wish {
    std::string file;
    bool strict = false;
    bool not_hil = false;
  };
  const auto wish = std::make_shared<Wish>();
  CLI::App* const load = line.add_verb(
      param, "load", "Write those of a file, in its order; names those that are not taken",
      "casctl param load iris.params", [wish](Session& session) {
        return load_params(session, wish->file, wish->strict, wish->not_hil);
      });
  load->add_option("FILE", wish->file,
                   "File to read, on this machine: of casctl, MAVProxy, Mission Planner or "
                   "QGroundControl")
      ->required();
  load->add_flag("--strict", wish->strict,
                 "Write nothing if a name is missing; end at the first that is not taken");
  add_consent(load, wish->not_hil);
}

void add_param(CommandLine& line) {
  struct Wish {
    std::string name, file, prefix;
    double value = 0;
    bool not_hil = false;
  };
  const auto wish = std::make_shared<Wish>();
  CLI::App* const param = line.add_group("param", "Read and write parameters");
  line.add_verb(param, "list", "List all, or those that begin with PREFIX", "casctl param list MC_",
                [wish](Session& session) { return list_params(session, wish->prefix); })
      ->add_option("PREFIX", wish->prefix, "Beginning of the names; left out: all");
  line.add_verb(
          param, "get", "Read one", "casctl param get MC_ROLL_P",
          [wish](Session& session) {
            return print_param(session, session.vehicle_call("param.get", {{"name", wish->name}}));
          })
      ->add_option("NAME", wish->name, "Parameter, by the firmware's name")
      ->required();
  CLI::App* const set =
      line.add_verb(param, "set", "Write one; prints old -> new", "casctl param set MC_ROLL_P 6.5",
                    [wish](Session& session) {
                      json params{{"name", wish->name}, {"value", wish->value}};
                      if (wish->not_hil) params["not_hil"] = true;
                      return print_param(session, session.vehicle_call("param.set", params));
                    });
  set->add_option("NAME", wish->name, "Parameter, by the firmware's name")->required();
  set->add_option("VALUE", wish->value, "Value to write")->required();
  add_consent(set, wish->not_hil);
  line.add_verb(param, "save", "Save all to a file", "casctl param save iris.params",
                [wish](Session& session) { return save_params(session, wish->file); })
      ->add_option("FILE", wish->file, "File to write, on this machine")
      ->required();
  add_param_load(line, param);
}

}  // namespace

void add_param_verbs(CommandLine& line) {
  add_setgain(line);
  add_gains(line);
  add_param(line);
}

}  // namespace cas::casctl

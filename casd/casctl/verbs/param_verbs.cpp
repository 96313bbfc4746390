// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "base/os/write_file.hpp"
#include "casd/casctl/session/gains_text.hpp"
#include "casd/casctl/session/table.hpp"
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
  const Verb verb =
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
  verb.add_option("LOOP", wish->loop,
                  "One of rollrate, roll, position, ...: `casctl gains` lists them")
      .required();
  const Argument values = verb.add_option("P I D", wish->values, "The three gains").expected(0, 3);
  for (auto [flag, slot] : {std::pair{"--p", &wish->p}, {"--i", &wish->i}, {"--d", &wish->d}}) {
    verb.add_option(flag, *slot, "This gain only").excludes(values);
  }
  verb.add_check([wish] {
    const bool named = wish->p || wish->i || wish->d;
    return named || !wish->values.empty() ? std::string() : "give P I D, or --p, --i, --d";
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
                  if (session.options().json) {
                    report(session.options(), loop->empty() ? all : all.at(0), "");
                  } else {
                    print_gains(all);
                  }
                  return kDone;
                })
      .add_option("LOOP", *loop, "Control loop; left out: all");
}

/// One line of a parameter file: NAME VALUE; '#' starts a comment.
std::optional<std::pair<std::string, double>> parse_param_line(std::string text,
                                                               const std::string& place) {
  text = text.substr(0, text.find('#'));
  std::istringstream in(text);
  std::string name;
  double value = 0;
  if (!(in >> name)) return std::nullopt;
  std::string rest;
  if (!(in >> value) || in >> rest) throw std::runtime_error(place + ": expected NAME VALUE");
  return std::pair{name, value};
}

/// ": A, B" of the parameters that a file cannot give back.
std::string names_text(const json& names) {
  std::string text;
  for (const json& name : names) text += (text.empty() ? ": " : ", ") + name.get<std::string>();
  return text;
}

int save_params(Session& session, const std::string& file) {
  const json list = session.vehicle_call("param.list");
  std::ostringstream out;
  json left_out = json::array();
  std::size_t saved = 0;
  out << "# Parameters of vehicle " << list.at("vehicle") << ": NAME VALUE\n";
  for (const json& entry : list.at("parameters")) {
    const auto name = entry.at("name").get<std::string>();
    const json& value = entry.at("value");
    if (value.is_number()) {
      out << name << ' ' << value.dump() << '\n';
      ++saved;
    } else {  // casd answers null, and would not write such a value either
      out << "# " << name << " is NaN or infinite\n";
      left_out.push_back(name);
    }
  }
  base::write_file(file, out.view());
  std::string sentence = std::to_string(saved) + " parameters saved to " + file;
  if (!left_out.empty()) sentence += "; NaN or infinite, so left out" + names_text(left_out);
  report(session.options(), {{"file", file}, {"saved", saved}, {"left_out", left_out}}, sentence);
  return kDone;
}

int load_params(Session& session, const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::vector<std::pair<std::string, double>> wishes;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    const auto wish = parse_param_line(text, file + ":" + std::to_string(number));
    if (wish) wishes.push_back(*wish);
  }
  for (const auto& [name, value] : wishes) {
    session.vehicle_call("param.set", {{"name", name}, {"value", value}});
  }
  report(session.options(), {{"file", file}, {"set", wishes.size()}},
         std::to_string(wishes.size()) + " parameters of " + file + " are in force");
  return kDone;
}

int list_params(Session& session, const std::string& prefix) {
  json list = session.vehicle_call("param.list");
  Table table({"NAME", "VALUE", "TYPE"});
  json kept = json::array();
  for (const json& entry : list.at("parameters")) {
    const std::string name = entry.at("name");
    if (name.compare(0, prefix.size(), prefix) != 0) continue;
    table.add({name, entry.at("value").dump(), entry.value("type", "?")});
    kept.push_back(entry);
  }
  list["parameters"] = kept;
  if (session.options().json) {
    report(session.options(), list, "");
  } else {
    table.print(std::cout);
  }
  return kDone;
}

int print_param(const Session& session, const json& result) {
  report(session.options(), result, param_text(result));
  return kDone;
}

void add_param(CommandLine& line) {
  struct Wish {
    std::string name, file, prefix;
    double value = 0;
  };
  const auto wish = std::make_shared<Wish>();
  const Verb param = line.add_group("param", "Read and write parameters");
  line.add_verb(param, "list", "List all, or those that begin with PREFIX", "casctl param list MC_",
                [wish](Session& session) { return list_params(session, wish->prefix); })
      .add_option("PREFIX", wish->prefix, "Beginning of the names; left out: all");
  line.add_verb(
          param, "get", "Read one", "casctl param get MC_ROLL_P",
          [wish](Session& session) {
            return print_param(session, session.vehicle_call("param.get", {{"name", wish->name}}));
          })
      .add_option("NAME", wish->name, "Parameter, by the firmware's name")
      .required();
  const Verb set = line.add_verb(
      param, "set", "Write one; prints old -> new", "casctl param set MC_ROLL_P 6.5",
      [wish](Session& session) {
        return print_param(session, session.vehicle_call("param.set", {{"name", wish->name},
                                                                       {"value", wish->value}}));
      });
  set.add_option("NAME", wish->name, "Parameter, by the firmware's name").required();
  set.add_option("VALUE", wish->value, "Value to write").required();
  line.add_verb(param, "save", "Save all to a file", "casctl param save iris.params",
                [wish](Session& session) { return save_params(session, wish->file); })
      .add_option("FILE", wish->file, "File to write, on this machine")
      .required();
  line.add_verb(param, "load", "Write those of a file, in its order",
                "casctl param load iris.params",
                [wish](Session& session) { return load_params(session, wish->file); })
      .add_option("FILE", wish->file, "File to read, on this machine")
      .required();
}

}  // namespace

void add_param_verbs(CommandLine& line) {
  add_setgain(line);
  add_gains(line);
  add_param(line);
}

}  // namespace cas::casctl

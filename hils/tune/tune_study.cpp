// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/config/config_keys.hpp"
#include "base/config/install_paths.hpp"

namespace cas::hils {

namespace {

constexpr double kMostNumber = 1e300;

/// All digits that tell it apart. @param whole  rounded
std::string number_text(double value, bool whole) {
  if (value == 0) value = 0;  // not -0
  return whole ? fmt::format("{:.0f}", value) : fmt::format("{}", value);
}

std::vector<TuneScenario> parse_scenarios(const base::ConfigNode& list,
                                          std::set<std::string>& names) {
  std::vector<TuneScenario> scenarios;
  for (const base::ConfigNode& node : list.items()) {
    TuneScenario scenario;
    scenario.name = node.require<std::string>("name");
    if (!is_plain_name(scenario.name))
      node.at("name").fail("is made of letters, digits and _ . - [ ]");
    if (scenario.name.find_first_not_of('.') == std::string::npos)
      node.at("name").fail("has more than dots: it is a folder's");
    if (!names.insert(scenario.name).second) node.at("name").fail("is a scenario's already");
    scenario.scenario = base::find_config(node.at("scenario"));
    scenario.settings = parse_settings(node);
    if (const auto ramp = node.find("delay_ramp")) {
      scenario.delay_ramp = DelayRamp::parse(*ramp);
      const auto has_faults = [](const KeyValue& each) { return each.first.starts_with("faults"); };
      if (std::ranges::any_of(scenario.settings, has_faults)) {
        ramp->fail("takes the place of the scenario's faults, and `set` has some");
      }
      scenario.settings.emplace_back("faults", scenario.delay_ramp->faults());
    }
    scenarios.push_back(std::move(scenario));
  }
  return scenarios;
}

std::vector<TuneParameter> parse_vary(const base::ConfigNode& root) {
  std::vector<TuneParameter> vary;
  const std::vector<base::ConfigNode> nodes = root.at("vary").items();
  for (const Parameter& parameter : parse_parameters(root)) {
    const base::ConfigNode& node = nodes[vary.size()];
    const auto& spread = parameter.distribution;
    if (!spread || spread->kind == Distribution::Kind::kNormal) {
      node.fail(
          "a number that is searched has `uniform` or `log`: its least and its largest value");
    }
    vary.push_back(
        {.parameter = parameter, .from = node.require_in("from", *spread->least, *spread->most)});
  }
  if (vary.empty()) root.at("vary").fail("is an empty list");
  return vary;
}

TuneFigure parse_figure(const base::ConfigNode& node, const std::vector<TuneScenario>& scenarios) {
  TuneFigure figure;
  const base::ConfigNode own = node.at("figure");
  if (own.is_list()) {
    figure.figures = own.as<std::vector<std::string>>();
  } else {
    figure.figures.push_back(own.as<std::string>());
  }
  if (figure.figures.empty()) own.fail("is an empty list");
  figure.name = node.get<std::string>("name", figure.figures.front());
  if (!is_plain_name(figure.name)) node.fail("its name is made of letters, digits and _ . - [ ]");
  const auto in = node.find("in");
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    if (!in && !scenarios[i].delay_ramp) figure.in.push_back(i);
  }
  if (!in) return figure;
  for (const base::ConfigNode& item : in->items()) {
    const auto found = std::ranges::find(scenarios, item.as<std::string>(), &TuneScenario::name);
    if (found == scenarios.end()) item.fail("is none of the study's scenarios");
    figure.in.push_back(static_cast<std::size_t>(found - scenarios.begin()));
  }
  if (figure.in.empty()) in->fail("is an empty list");
  return figure;
}

Guard parse_guard(const base::ConfigNode& node, const std::vector<TuneScenario>& scenarios) {
  Guard guard{.figure = parse_figure(node, scenarios), .at_least = true, .bound = std::nullopt};
  if (node.has("at_least") == node.has("at_most")) node.fail("has at_least or at_most");
  guard.at_least = node.has("at_least");
  const char* key = guard.at_least ? "at_least" : "at_most";
  if (node.at(key).as<std::string>() != "before") {
    guard.bound = node.require_in(key, -kMostNumber, kMostNumber);
  }
  return guard;
}

constexpr base::Words<SearchMethod, 2> kMethods{
    {{{"nsga2", SearchMethod::kNsga2}, {"cmaes", SearchMethod::kCmaes}}}, "is nsga2 or cmaes"};

constexpr std::tuple kSearchKeys{
    base::key<&TuneStudy::method>("method", kMethods, ""),
    base::key<&TuneStudy::population>("population", base::Whole{5, 10'000}, ""),
    base::key<&TuneStudy::generations>("generations", base::Whole{0, 1'000'000}, ""),
    base::key<&TuneStudy::seed>("seed", base::Count{}, ""),
};

void parse_search(const base::ConfigNode& root, TuneStudy& study) {
  const auto node = root.find("search");
  if (!node) return;
  base::read_keys(*node, kSearchKeys, study);
  if (study.method == SearchMethod::kNsga2 && (study.population < 8 || study.population % 4 != 0)) {
    node->fail("'population' of nsga2 is a multiple of 4, 8 or more");
  }
}

}  // namespace

std::string TuneParameter::value_at(double u) const {
  const Distribution& spread = *parameter.distribution;
  if (parameter.whole) {
    const double least = std::ceil(*spread.least);
    const double most = std::max(least, std::floor(*spread.most));
    return number_text(std::clamp(std::round(spread.quantile(u)), least, most), true);
  }
  const double four_digits = std::stod(fmt::format("{:.4g}", spread.quantile(u)));
  return number_text(std::clamp(four_digits, *spread.least, *spread.most), false);
}

double TuneParameter::place() const {
  const Distribution& spread = *parameter.distribution;
  if (spread.kind == Distribution::Kind::kLog) {
    return std::log(from / *spread.least) / std::log(*spread.most / *spread.least);
  }
  return (from - *spread.least) / (*spread.most - *spread.least);
}

TuneStudy TuneStudy::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  TuneStudy study;
  read_head(root, file, study);
  std::set<std::string> names;
  study.scenarios = parse_scenarios(root.at("scenarios"), names);
  if (study.scenarios.empty()) root.at("scenarios").fail("is an empty list");
  study.seeds = {1};
  if (const auto seeds = root.find("seeds")) study.seeds = parse_seed_list(*seeds);
  study.vary = parse_vary(root);
  for (const base::ConfigNode& node : root.at("objectives").items()) {
    study.objectives.push_back({.figure = parse_figure(node, study.scenarios),
                                .weight = node.get_in("weight", 1, 0, kMostNumber)});
  }
  if (study.objectives.empty()) root.at("objectives").fail("is an empty list");
  if (const auto guards = root.find("guards")) {
    for (const base::ConfigNode& node : guards->items()) {
      study.guards.push_back(parse_guard(node, study.scenarios));
    }
  }
  parse_search(root, study);
  if (const auto verify = root.find("verify")) {
    study.verify_seeds = parse_seed_list(verify->at("seeds"));
    for (const std::uint64_t seed : study.verify_seeds) {
      if (std::ranges::find(study.seeds, seed) == study.seeds.end()) continue;
      verify->at("seeds").fail(fmt::format("has seed {}, which the search uses", seed));
    }
    if (const auto list = verify->find("scenarios")) {
      study.verify_scenarios = parse_scenarios(*list, names);
    }
  }
  root.reject_unused();
  return study;
}

std::vector<KeyValue> TuneStudy::values_of(const std::vector<std::string>& candidate) const {
  std::vector<KeyValue> values;
  for (std::size_t i = 0; i < vary.size(); ++i) {
    for (const std::string& key : vary[i].parameter.keys) values.emplace_back(key, candidate[i]);
  }
  return values;
}

std::vector<std::string> TuneStudy::before() const {
  std::vector<std::string> values;
  for (const TuneParameter& each : vary) {
    values.push_back(number_text(each.from, each.parameter.whole));
  }
  return values;
}

}  // namespace cas::hils

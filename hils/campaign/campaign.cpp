// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "base/suggestion.hpp"
#include "hils/sweep/study.hpp"
#include "plugins/fault/expression.hpp"

namespace cas::hils {

namespace {

constexpr int kSchema = 1;

void check_name(const base::ConfigNode& node, const std::string& name) {
  if (!is_plain_name(name)) {
    node.fail("its name '" + name + "' is made of letters, digits and _ . - [ ]");
  }
}

void check_condition(const base::ConfigNode& node, const std::string& when) {
  try {
    sim::Expression::parse(when);
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
}

std::vector<CampaignPhase> parse_phases(const base::ConfigNode& map) {
  std::vector<CampaignPhase> phases;
  for (const auto& [name, node] : map.entries()) {
    check_name(node, name);
    phases.push_back({.name = name, .when = node.as<std::string>()});
    check_condition(node, phases.back().when);
  }
  if (phases.empty()) map.fail("names at least one phase, such as 'hover: phase == hover'");
  return phases;
}

const Failure& parse_failure_name(const base::ConfigNode& node) {
  const auto name = node.as<std::string>();
  if (const Failure* failure = find_failure(name)) return *failure;
  std::vector<std::string_view> known;
  for (const Failure& each : failure_catalogue()) known.push_back(each.name);
  node.fail("the catalogue has no failure '" + name + "'; 'hils campaign --list' prints it" +
            base::did_you_mean(name, known));
}

/// The block `with`: parameters of the failure, and how long it lasts.
std::map<std::string, double, std::less<>> parse_values(const base::ConfigNode& node,
                                                        const Failure& failure) {
  std::map<std::string, double, std::less<>> values;
  const auto with = node.find("with");
  if (!with) return values;
  for (const FailureParameter& each : failure.parameters) {
    const std::string name(each.name);
    if (with->has(name)) values[name] = with->require_in(name, each.least, each.most);
  }
  if (with->has(kDuration)) {
    values[std::string(kDuration)] = with->require_in(kDuration, 0.001, 3600);
  }
  with->reject_unused();
  return values;
}

/// The phases in which a failure strikes: all, or those of its list `phases`.
std::set<std::string> parse_own_phases(const base::ConfigNode& node,
                                       const std::vector<CampaignPhase>& phases) {
  std::set<std::string> known;
  for (const CampaignPhase& phase : phases) known.insert(phase.name);
  const auto list = node.find("phases");
  if (!list) return known;
  std::set<std::string> own;
  for (const base::ConfigNode& item : list->items()) {
    const auto name = item.as<std::string>();
    if (!known.contains(name)) item.fail("the campaign has no phase '" + name + "'");
    own.insert(name);
  }
  return own;
}

CampaignFailure parse_failure(const base::ConfigNode& node,
                              const std::vector<CampaignPhase>& phases) {
  CampaignFailure failure;
  failure.failure = &parse_failure_name(node.at("failure"));
  failure.name = node.get<std::string>("name", std::string(failure.failure->name));
  check_name(node, failure.name);
  failure.values = parse_values(node, *failure.failure);
  const std::set<std::string> own = parse_own_phases(node, phases);
  std::optional<std::vector<Expectation>> usual;
  if (const auto list = node.find("expect")) usual = parse_expectations(*list);
  const base::ConfigNode other = node.find("expect_in").value_or(base::ConfigNode::empty());
  for (const CampaignPhase& phase : phases) {
    if (!own.contains(phase.name)) continue;
    if (const auto list = other.find(phase.name)) {
      failure.expected[phase.name] = parse_expectations(*list);
    } else if (usual) {
      failure.expected[phase.name] = *usual;
    } else {
      node.fail("says for phase '" + phase.name +
                "' neither in 'expect' nor in 'expect_in' what must happen");
    }
  }
  other.reject_unused();
  return failure;
}

/// In single quotes, as YAML has it.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

/// YAML of a value below its key, which may be a map in several lines.
std::string block(const std::string& value) {
  std::string text = "\n    ";
  for (const char c : value) text += c == '\n' ? std::string("\n    ") : std::string(1, c);
  return text + "\n";
}

std::string faults_of_cell(const Campaign& campaign, const CampaignCell& cell) {
  const CampaignFailure& failure = campaign.failures[cell.failure];
  const CampaignPhase& phase = campaign.phases[cell.phase];
  return faults_of(*failure.failure, failure.name + " in " + phase.name, phase.when,
                   failure.values);
}

/// Reads the faults of each cell as the scenario would. @throws base::ConfigError
void check_cells(const Campaign& campaign) {
  const Scenario scenario = Scenario::load(campaign.scenario);
  for (const CampaignCell& cell : cells_of(campaign)) {
    const CampaignFailure& failure = campaign.failures[cell.failure];
    const std::string text = "faults: " + faults_of_cell(campaign, cell);
    try {
      parse_scenario_faults(base::ConfigNode::parse(text, failure.name).at("faults"), scenario.line,
                            scenario.names());
    } catch (const base::ConfigError& error) {
      throw base::ConfigError(fmt::format("failure '{}' in {}: {}", failure.name,
                                          campaign.phases[cell.phase].name, error.what()));
    }
  }
}

}  // namespace

Campaign Campaign::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  if (root.require<int>("schema") != kSchema) root.at("schema").fail("this program reads schema 1");
  Campaign campaign;
  campaign.name = root.get<std::string>("name", file.stem().string());
  campaign.description = root.get<std::string>("description", "");
  campaign.scenario = std::filesystem::absolute(base::find_config(root.at("scenario")));
  try {
    campaign.architecture = parse_architecture(root.get<std::string>("architecture", "direct"));
  } catch (const base::ConfigError& error) {
    root.at("architecture").fail(error.what());
  }
  campaign.phases = parse_phases(root.at("phases"));
  campaign.seeds =
      root.has("seeds") ? parse_seed_list(root.at("seeds")) : std::vector{std::uint64_t{1}};
  campaign.deadline_s = root.get_in("deadline_s", campaign.deadline_s, 1, 1e6);
  campaign.settings = parse_settings(root);
  std::set<std::string> names;
  for (const base::ConfigNode& node : root.at("failures").items()) {
    campaign.failures.push_back(parse_failure(node, campaign.phases));
    if (!names.insert(campaign.failures.back().name).second) {
      node.fail("two failures are called '" + campaign.failures.back().name +
                "'; give one another 'name'");
    }
  }
  root.reject_unused();
  if (cells_of(campaign).empty()) root.at("failures").fail("has nothing that can be flown");
  check_cells(campaign);
  return campaign;
}

std::vector<CampaignCell> cells_of(const Campaign& campaign) {
  std::vector<CampaignCell> cells;
  for (std::size_t i = 0; i < campaign.failures.size(); ++i) {
    const CampaignFailure& failure = campaign.failures[i];
    if (failure.failure->needs != FailureNeeds::kNothing) continue;
    for (std::size_t j = 0; j < campaign.phases.size(); ++j) {
      if (failure.expected.contains(campaign.phases[j].name)) cells.push_back({i, j});
    }
  }
  return cells;
}

std::string study_of(const Campaign& campaign) {
  std::string text = fmt::format(
      "# Made by hils campaign: a row's faults are one failure in one phase.\n"
      "schema: 1\nname: {}\ndescription: {}\nscenario: {}\narchitecture: {}\ndeadline_s: {:g}\n",
      quoted(campaign.name), quoted(campaign.description), quoted(campaign.scenario.string()),
      to_string(campaign.architecture), campaign.deadline_s);
  text += "seeds: [";
  for (std::size_t i = 0; i < campaign.seeds.size(); ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : ", ", campaign.seeds[i]);
  }
  text += "]\n";
  if (!campaign.settings.empty()) text += "set:\n";
  for (const auto& [key, value] : campaign.settings) {
    text += fmt::format("  {}:{}", quoted(key), block(value));
  }
  text += "vary:\n  - name: cell\n    key: faults\n    values:\n";
  for (const CampaignCell& cell : cells_of(campaign)) {
    text += "      - " + quoted(faults_of_cell(campaign, cell)) + "\n";
  }
  return text;
}

}  // namespace cas::hils

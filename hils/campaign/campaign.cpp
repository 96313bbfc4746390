// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/campaign.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <string_view>

#include "base/config/config.hpp"
#include "base/config/file_kind.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/vehicle.hpp"
#include "base/suggestion.hpp"
#include "hils/flight/phase_check.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/sweep/key_path.hpp"
#include "hils/sweep/study.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

namespace {

/// Text that goes to a terminal. @throws base::ConfigError
void check_line(const base::ConfigNode& root, const char* key, const std::string& text) {
  const auto is_control = [](unsigned char c) { return std::iscntrl(c) != 0; };
  if (std::ranges::any_of(text, is_control)) root.at(key).fail("has a control character in it");
}

std::vector<CampaignPhase> parse_phases(const base::ConfigNode& map, const Scenario& scenario) {
  std::vector<CampaignPhase> phases;
  for (const auto& [name, node] : map.entries()) {
    check_name(node, name);
    phases.push_back({.name = name, .when = node.as<std::string>()});
    check_phases(node, scenario.steps);
  }
  if (phases.empty()) map.fail("names at least one phase, such as 'hover: phase == hover'");
  return phases;
}

/// The shipped failures and those of the campaign's own file. @throws base::ConfigError
FailureCatalogue parse_catalogue(const base::ConfigNode& root) {
  FailureCatalogue catalogue = FailureCatalogue::shipped();
  if (const auto own = root.find("catalogue")) {
    catalogue.add(base::find_config(*own));
  }
  return catalogue;
}

const Failure& parse_failure_name(const base::ConfigNode& node, const FailureCatalogue& catalogue) {
  const auto name = node.as<std::string>();
  if (const Failure* failure = catalogue.find(name)) return *failure;
  std::vector<std::string_view> known;
  for (const Failure& each : catalogue.failures()) known.push_back(each.name);
  node.fail("the catalogue has no failure '" + name + "'; 'hils campaign " + node.file().string() +
            " --list' prints it" + base::did_you_mean(name, known));
}

/// The block `with`: parameters of the failure, and how long it lasts.
std::map<std::string, double, std::less<>> parse_values(const base::ConfigNode& node,
                                                        const Failure& failure) {
  std::map<std::string, double, std::less<>> values;
  const auto with = node.find("with");
  if (!with) return values;
  for (const FailureParameter& each : failure.parameters) {
    if (with->has(each.name)) {
      values[each.name] = with->require_in(each.name, each.least, each.most);
    }
  }
  if (with->has(kDuration)) {
    values[std::string(kDuration)] = with->require_in(kDuration, 0.001, 3600);
  }
  with->reject_unused();
  return values;
}

void check_phase(const base::ConfigNode& node, const std::string& name,
                 const std::vector<CampaignPhase>& phases) {
  if (std::ranges::find(phases, name, &CampaignPhase::name) != phases.end()) return;
  std::vector<std::string_view> words;
  for (const CampaignPhase& phase : phases) words.push_back(phase.name);
  node.fail("the campaign has no phase '" + name + "'" + base::did_you_mean(name, words));
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
    check_phase(item, name, phases);
    own.insert(name);
  }
  return own;
}

CampaignFailure parse_failure(const base::ConfigNode& node, const FailureCatalogue& catalogue,
                              const std::vector<CampaignPhase>& phases) {
  CampaignFailure failure;
  failure.failure = parse_failure_name(node.at("failure"), catalogue);
  failure.name = node.get<std::string>("name", failure.failure.name);
  check_name(node, failure.name);
  failure.values = parse_values(node, failure.failure);
  const std::set<std::string> own = parse_own_phases(node, phases);
  std::optional<std::vector<Expectation>> usual;
  if (const auto list = node.find("expect")) usual = parse_expectations(*list);
  const base::ConfigNode other = node.find("expect_in").value_or(base::ConfigNode::empty());
  for (const auto& [phase, list] : other.entries()) {
    check_phase(list, phase, phases);
    if (!own.contains(phase)) list.fail("the failure does not strike in phase '" + phase + "'");
  }
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
  return failure;
}

std::string faults_of_cell(const Campaign& campaign, const CampaignCell& cell) {
  const CampaignFailure& failure = campaign.failures[cell.failure];
  const CampaignPhase& phase = campaign.phases[cell.phase];
  return faults_of(failure.failure, failure.name + " in " + phase.name, phase.when, failure.values);
}

/// Reads the faults of the campaign's last failure as the scenario and its vehicle would.
/// @throws base::ConfigError
void check_failure(const base::ConfigNode& node, const Campaign& campaign, const Scenario& scenario,
                   const base::Vehicle& vehicle) {
  const std::size_t last = campaign.failures.size() - 1;
  const base::ConfigNode place = node.find("with").value_or(node);
  for (std::size_t i = 0; i < campaign.phases.size(); ++i) {
    if (!campaign.failures[last].expected.contains(campaign.phases[i].name)) continue;
    const std::string text = "faults: " + faults_of_cell(campaign, {last, i});
    ScenarioFaults faults;
    try {
      faults = parse_scenario_faults(base::ConfigNode::parse(text).at("faults"), scenario.line,
                                     scenario.names());
    } catch (const base::ConfigError& error) {
      place.fail(error.what());
    }
    for (const VehicleFault& fault : faults.vehicle) {
      const std::string missing =
          sim::missing_part(sim::parse_fault(fault.script, 1).kind, vehicle);
      if (!missing.empty()) place.fail(missing);
    }
  }
}

/// The scenario as its flights have it. @throws base::ConfigError
Scenario scenario_of(const base::ConfigNode& root, const Campaign& campaign) {
  if (campaign.settings.empty()) return Scenario::load(campaign.scenario);
  const RunDirectory scratch;
  try {
    write_scenario(campaign.scenario, campaign.settings, campaign.folder, scratch.path());
    return Scenario::load(scratch.path() / "scenario.yaml");
  } catch (const base::ConfigError& error) {
    root.at("set").fail(without_folder(error.what(), scratch.path()));
  }
}

/// Why the flight of a scenario cannot have these faults; nullopt: it can. Stock firmware may have
/// sensors of its own.
std::optional<std::string> lack_for(const ScenarioFaults& faults, const Scenario& scenario,
                                    const std::set<std::string>& plugins) {
  for (const BenchFault& fault : faults.bench) {
    const auto* silence = std::get_if<SilenceFault>(&fault.kind);
    if (silence != nullptr && silence->sticks && !has_sticks(scenario)) {
      return "needs sticks, and nothing in this flight sends them";
    }
  }
  for (const VehicleFault& fault : faults.vehicle) {
    const std::string needed = sim::needed_plugin(sim::parse_fault(fault.script, 1).kind);
    if (needed.empty() || plugins.contains(needed)) continue;
    if (!scenario.firmware || plugins.contains("imu")) {
      return fmt::format("needs {}, which this vehicle does not have", needed);
    }
    return fmt::format(
        "needs plugin {} in the simulator, and this autopilot has sensors of its own", needed);
  }
  return std::nullopt;
}

/// Finds out which failures the bench cannot play.
void note_obstacles(Campaign& campaign, const Scenario& scenario) {
  const CampaignBench bench = campaign.is_on_boards() ? CampaignBench::kBoard
                              : campaign.on_firmware  ? CampaignBench::kFirmware
                                                      : CampaignBench::kVirtualClock;
  const std::set<std::string> plugins = plugins_of(scenario, 0);
  for (std::size_t i = 0; i < campaign.failures.size(); ++i) {
    CampaignFailure& failure = campaign.failures[i];
    if (const auto why = obstacle(failure.failure, bench)) failure.obstacle = std::string(*why);
    if (failure.obstacle || failure.expected.empty()) continue;
    const std::string text = "faults: " + faults_of_cell(campaign, {i, 0});
    const auto faults = parse_scenario_faults(base::ConfigNode::parse(text).at("faults"),
                                              scenario.line, scenario.names());
    failure.obstacle = lack_for(faults, scenario, plugins);
  }
}

/// Leaves the failures of these names alone. @throws base::ConfigError
void choose_failures(Campaign& campaign, const std::vector<std::string>& only,
                     const std::filesystem::path& file) {
  if (only.empty()) return;
  std::vector<std::string_view> known;
  for (const CampaignFailure& each : campaign.failures) known.push_back(each.name);
  for (const std::string& name : only) {
    if (std::ranges::find(known, name) != known.end()) continue;
    throw base::ConfigError("--only: " + file.string() + " has no failure '" + name + "'" +
                            base::did_you_mean(name, known));
  }
  std::erase_if(campaign.failures, [&](const CampaignFailure& each) {
    if (std::ranges::find(only, each.name) != only.end()) return false;
    campaign.left_out.push_back(each.name);
    return true;
  });
}

/// What a campaign is called, and what it flies. @throws base::ConfigError
Campaign parse_head(const base::ConfigNode& root, const std::filesystem::path& file) {
  base::expect_file(root, base::FileKind::kStudy);
  Campaign campaign;
  campaign.folder = std::filesystem::absolute(file).parent_path();
  read_head(root, file, campaign);
  check_line(root, "name", campaign.name);
  check_line(root, "description", campaign.description);
  campaign.scenario = std::filesystem::absolute(base::find_config(root.at("scenario")));
  campaign.settings = parse_settings(root);
  campaign.seeds =
      root.has("seeds") ? parse_seed_list(root.at("seeds")) : std::vector{std::uint64_t{1}};
  return campaign;
}

/// Refuses a scenario that campaigns do not fly. @throws base::ConfigError
void check_scenario(const base::ConfigNode& node, const Scenario& scenario) {
  if (scenario.firmware && scenario.firmware->on_serial_line) {
    node.fail("flies in real time on one serial line; a campaign flies firmware in software");
  }
  if (scenario.flies_several()) {
    node.fail("flies several vehicles; that of a campaign flies one");
  }
}

void parse_failures(const base::ConfigNode& root, const Scenario& scenario, Campaign& campaign) {
  const auto vehicle = base::Vehicle::load(scenario.vehicles.front().vehicle);
  const FailureCatalogue catalogue = parse_catalogue(root);
  std::set<std::string> names;
  for (const base::ConfigNode& node : root.at("failures").items()) {
    campaign.failures.push_back(parse_failure(node, catalogue, campaign.phases));
    if (!names.insert(campaign.failures.back().name).second) {
      node.fail("two failures are called '" + campaign.failures.back().name +
                "'; give one another 'name'");
    }
    check_failure(node, campaign, scenario, vehicle);
  }
}

/// Who flies it: stock firmware, boards, or our controller on the virtual clock.
/// @throws base::ConfigError
void choose_bench(const base::ConfigNode& root, const Scenario& scenario,
                  const CampaignChoice& choice, Campaign& campaign) {
  campaign.on_firmware = scenario.firmware.has_value();
  if (campaign.on_firmware) campaign.architecture = scenario.architecture;
  campaign.controllers = choice.controllers;
  if (campaign.on_firmware && campaign.is_on_boards()) {
    root.at("scenario").fail("is flown by stock firmware, and --fcu by a board: take another one");
  }
  if (campaign.is_on_boards() && campaign.architecture == Architecture::kDirect) {
    campaign.architecture = Architecture::kTcas;  // direct has no line at whose end a board is
  }
}

}  // namespace

Campaign Campaign::load(const std::filesystem::path& file, const CampaignChoice& choice) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  Campaign campaign = parse_head(root, file);
  const Scenario scenario = scenario_of(root, campaign);
  check_scenario(root.at("scenario"), scenario);
  campaign.phases = parse_phases(root.at("phases"), scenario);
  parse_failures(root, scenario, campaign);
  root.reject_unused();
  choose_failures(campaign, choice.only, file);
  choose_bench(root, scenario, choice, campaign);
  note_obstacles(campaign, scenario);
  if (cells_of(campaign).empty()) root.at("failures").fail("has nothing that can be flown");
  return campaign;
}

FailureCatalogue catalogue_of(const std::filesystem::path& campaign) {
  return parse_catalogue(base::ConfigNode::load(campaign));
}

std::vector<CampaignCell> cells_of(const Campaign& campaign) {
  std::vector<CampaignCell> cells;
  for (std::size_t i = 0; i < campaign.failures.size(); ++i) {
    const CampaignFailure& failure = campaign.failures[i];
    if (failure.obstacle) continue;
    for (std::size_t j = 0; j < campaign.phases.size(); ++j) {
      if (failure.expected.contains(campaign.phases[j].name)) cells.push_back({i, j});
    }
  }
  return cells;
}

std::string study_of(const Campaign& campaign) {
  YAML::Node study(YAML::NodeType::Map);
  study["schema"] = 1;
  study["name"] = campaign.name;
  study["description"] = campaign.description;
  study["scenario"] = campaign.scenario.string();
  study["architecture"] = std::string(to_string(campaign.architecture));
  study["deadline_s"] = fmt::format("{}", campaign.deadline_s);
  study["seeds"] = campaign.seeds;
  for (const auto& [key, value] : campaign.settings) study["set"][key] = YAML::Load(value);
  YAML::Node cell(YAML::NodeType::Map);
  cell["name"] = "cell";
  cell["key"] = "faults";
  for (const CampaignCell& each : cells_of(campaign)) {
    cell["values"].push_back(faults_of_cell(campaign, each));
  }
  cell["values"].push_back("null");
  study["vary"].push_back(cell);
  YAML::Emitter text;
  text << study;
  const std::string where =
      campaign.is_on_boards()
          ? fmt::format("# In real time, --fcu {}.\n", fmt::join(campaign.controllers, " --fcu "))
          : std::string();
  return fmt::format(
      "# Made by hils campaign: a row's faults are one failure in one phase.\n{}{}\n", where,
      text.c_str());
}

}  // namespace cas::hils

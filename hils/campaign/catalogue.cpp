// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/catalogue.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <utility>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/sweep/study.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

namespace {

/// Failures of the bench end by themselves where a campaign says nothing; s.
constexpr double kBenchLasts_s = 5;

/// Effects of the bench, and their needs. All others are the vehicle's.
struct BenchEffect {
  std::string_view key;
  FailureNeeds needs;
  bool unrecorded = false;
};
constexpr std::array kBenchEffects{
    BenchEffect{"unplug", FailureNeeds::kLineModel},
    BenchEffect{"line", FailureNeeds::kLineModel},
    BenchEffect{"silence", FailureNeeds::kVirtualClock, true},
    BenchEffect{"restart", FailureNeeds::kNothing},
    BenchEffect{"reload", FailureNeeds::kPrograms},
    BenchEffect{"starve", FailureNeeds::kVirtualClock},
};

/// A text of one line that does not break the table of the catalogue.
std::string parse_words(const base::ConfigNode& node, const char* key) {
  const auto text = node.require<std::string>(key);
  const auto breaks = [](unsigned char c) { return std::iscntrl(c) != 0 || c == '|'; };
  if (text.empty() || std::ranges::any_of(text, breaks)) {
    node.at(key).fail("must be one line that is not empty and has no '|'");
  }
  return text;
}

std::vector<FailureParameter> parse_parameters(const base::ConfigNode& node) {
  std::vector<FailureParameter> parameters;
  const auto map = node.find("parameters");
  if (!map) return parameters;
  for (const auto& [name, figures] : map->entries()) {
    FailureParameter parameter{.name = name};
    check_name(figures, name);
    if (name == kDuration) figures.fail("every failure takes this one");
    parameter.least = figures.require<double>("least");
    parameter.most = figures.require<double>("most");
    if (!(parameter.least <= parameter.most)) figures.at("most").fail("is less than 'least'");
    parameter.usual = figures.require_in("usual", parameter.least, parameter.most);
    parameters.push_back(std::move(parameter));
  }
  return parameters;
}

void parse_effects(const base::ConfigNode& list, Failure& failure) {
  const std::vector<base::ConfigNode> effects = list.items();
  if (effects.empty()) list.fail("must have at least one effect");
  std::size_t of_bench = 0;
  std::set<FailureNeeds> needed{FailureNeeds::kNothing};
  for (const base::ConfigNode& effect : effects) {
    const auto entries = effect.entries();
    if (entries.size() != 1) effect.fail("must be one effect of a scenario's faults");
    effect.mark_used();
    failure.effects.push_back(effect.dump());
    const auto known = std::ranges::find(kBenchEffects, entries[0].first, &BenchEffect::key);
    if (known == kBenchEffects.end()) continue;
    ++of_bench;
    // Sticks are lost on every bench that has some, and the vehicle does without them or reacts.
    const bool of_sticks =
        known->key == "silence" && entries[0].second.as<std::string>() == "sticks";
    needed.insert(of_sticks ? FailureNeeds::kNothing : known->needs);
    failure.unrecorded |= known->unrecorded && !of_sticks;
  }
  failure.needs = *needed.rbegin();
  if (needed.contains(FailureNeeds::kPrograms) && failure.needs != FailureNeeds::kPrograms) {
    list.fail("needs casd as a program and the virtual clock: no bench has both");
  }
  failure.of_bench = of_bench > 0;
  if (failure.of_bench && of_bench < effects.size()) {
    list.fail("mixes effects of the bench and of the vehicle");
  }
}

double value_of(const FailureParameter& parameter,
                const std::map<std::string, double, std::less<>>& values) {
  const auto given = values.find(parameter.name);
  return given == values.end() ? parameter.usual : given->second;
}

/// The effect with each $NAME replaced, the longest names first.
std::string filled(std::string_view effect, const Failure& failure,
                   const std::map<std::string, double, std::less<>>& values) {
  std::vector<FailureParameter> parameters = failure.parameters;
  std::ranges::sort(parameters, std::ranges::greater(),
                    [](const FailureParameter& each) { return each.name.size(); });
  std::string text(effect);
  for (const FailureParameter& parameter : parameters) {
    const std::string mark = "$" + parameter.name;
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark)) {
      text.replace(at, mark.size(), fmt::format("{}", value_of(parameter, values)));
    }
  }
  return text;
}

/// Reads the effects with usual values, as a scenario and plugin `fault` do. @throws
/// base::ConfigError
void check_effects(const base::ConfigNode& node, const Failure& failure) {
  const std::string list = faults_of(failure, failure.name, "armed", {});
  const base::ConfigNode effects = node.at("effects");
  if (const std::size_t at = list.find('$'); at != std::string::npos) {
    effects.fail("there is no parameter " + list.substr(at, list.find_first_of(" ,]}", at) - at));
  }
  for (const FailureParameter& parameter : failure.parameters) {
    const auto has = [mark = "$" + parameter.name](const std::string& effect) {
      return effect.find(mark) != std::string::npos;
    };
    if (std::ranges::any_of(failure.effects, has)) continue;
    node.at("parameters").at(parameter.name).fail("no effect has $" + parameter.name);
  }
  try {
    const auto text = base::ConfigNode::parse("faults: " + list, "with its usual values");
    const auto line = base::ConfigNode::parse("{preset: baud_921600}", "line");
    for (const VehicleFault& fault : parse_scenario_faults(text.at("faults"), line).vehicle) {
      sim::parse_fault(fault.script, 1);
      fault.script.reject_unused();
    }
  } catch (const base::ConfigError& error) {
    effects.fail(error.what());
  }
}

Failure parse_failure(const std::string& name, const base::ConfigNode& node) {
  Failure failure;
  failure.name = name;
  failure.part = parse_words(node, "part");
  failure.meaning = parse_words(node, "meaning");
  failure.physics = parse_words(node, "physics");
  failure.source = parse_words(node, "source");
  failure.parameters = parse_parameters(node);
  parse_effects(node.at("effects"), failure);
  check_effects(node, failure);
  return failure;
}

std::string parameter_words(const Failure& failure) {
  return base::joined(failure.parameters, ", ", [](const FailureParameter& each) {
    return fmt::format("{} {:g} ({:g} to {:g})", each.name, each.usual, each.least, each.most);
  });
}

}  // namespace

void check_name(const base::ConfigNode& node, const std::string& name) {
  if (!is_plain_name(name)) {
    node.fail("its name '" + name + "' is made of letters, digits and _ . - [ ]");
  }
}

FailureCatalogue FailureCatalogue::shipped() {
  FailureCatalogue catalogue;
  catalogue.add(base::shipped_config("failures.yaml"));
  return catalogue;
}

void FailureCatalogue::add(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  for (const auto& [name, node] : root.entries()) {
    check_name(node, name);
    if (find(name) != nullptr) node.fail("there is a failure of this name already");
    failures_.push_back(parse_failure(name, node));
  }
  root.reject_unused();
}

const Failure* FailureCatalogue::find(std::string_view name) const {
  const auto found = std::ranges::find(failures_, name, &Failure::name);
  return found == failures_.end() ? nullptr : &*found;
}

std::optional<std::string_view> obstacle(const Failure& failure, CampaignBench bench) {
  const bool on_virtual_clock = bench == CampaignBench::kVirtualClock;
  switch (failure.needs) {
    case FailureNeeds::kNothing:
      break;
    case FailureNeeds::kPrograms:
      if (on_virtual_clock) return "needs casd as a program";
      break;
    case FailureNeeds::kVirtualClock:
      if (!on_virtual_clock) return "needs the virtual clock";
      break;
    case FailureNeeds::kLineModel:
      if (bench == CampaignBench::kBoard) {
        return "needs the emulated line: a real port cannot play it";
      }
      if (bench == CampaignBench::kFirmware) return "needs a line: firmware in software has none";
      break;
  }
  return std::nullopt;
}

std::string faults_of(const Failure& failure, const std::string& title, const std::string& when,
                      const std::map<std::string, double, std::less<>>& values) {
  const auto given = values.find(kDuration);
  YAML::Node list(YAML::NodeType::Sequence);
  for (const std::string& effect : failure.effects) {
    YAML::Node fault(YAML::NodeType::Map);
    fault["name"] = title;
    fault["when"] = when;
    if (failure.of_bench) fault["of"] = "truth";
    if (given != values.end() || failure.of_bench) {
      const double lasts_s = given != values.end() ? given->second : kBenchLasts_s;
      fault[std::string(kDuration)] = fmt::format("{}", lasts_s);
    }
    for (const auto& entry : YAML::Load(filled(effect, failure, values))) {
      fault[entry.first.as<std::string>()] = entry.second;
    }
    list.push_back(fault);
  }
  YAML::Emitter text;
  text << YAML::Flow << list;
  return text.c_str();
}

std::string FailureCatalogue::text() const {
  std::string text;
  for (const Failure& each : failures_) {
    text += fmt::format("{} ({}): {}\n  physics: {}\n", each.name, each.part, each.meaning,
                        each.physics);
    if (!each.parameters.empty()) text += fmt::format("  parameters: {}\n", parameter_words(each));
    text += fmt::format("  source: {}\n", each.source);
    if (each.needs == FailureNeeds::kPrograms) {
      text += "  needs casd as a program: a campaign names it and does not fly it\n";
    }
  }
  text += fmt::format(
      "{} failures. Each takes for_s, too: how long it lasts (to the end; {:g} s "
      "where line, ground or casd fail)\n",
      failures_.size(), kBenchLasts_s);
  return text;
}

std::string FailureCatalogue::markdown() const {
  std::string text = "| failure | what has gone wrong | parameters |\n|---|---|---|\n";
  for (const Failure& each : failures_) {
    const std::string words = parameter_words(each);
    text +=
        fmt::format("| `{}` | {} | {} |\n", each.name, each.meaning, words.empty() ? "-" : words);
  }
  return text;
}

}  // namespace cas::hils

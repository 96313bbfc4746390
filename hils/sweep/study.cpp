// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cctype>
#include <cmath>
#include <set>
#include <string_view>

#include "base/config/config_keys.hpp"
#include "base/config/file_kind.hpp"
#include "base/config/install_paths.hpp"
#include "base/text.hpp"
#include "hils/sweep/key_path.hpp"
#include "hils/sweep/run_table.hpp"

namespace cas::hils {

namespace {

using base::key;
using base::Range;
using base::required;
using base::Words;

constexpr int kMostPoints = 10'000'000;
constexpr double kMostNumber = 1e300;

std::pair<double, double> parse_ends(const base::ConfigNode& node) {
  const auto ends = node.as<std::vector<double>>();
  if (ends.size() != 2 || !(ends[0] < ends[1])) node.fail("is [LEAST, MOST] with LEAST < MOST");
  return {ends[0], ends[1]};
}

/// `range: {from, to, count}` or `{from, to, step}`: both ends are in it where the step fits.
std::vector<std::string> parse_range(const base::ConfigNode& node) {
  const double from = node.require_in("from", -kMostNumber, kMostNumber);
  const double to = node.require_in("to", -kMostNumber, kMostNumber);
  std::vector<std::string> values;
  if (node.has("step")) {
    if (node.has("count")) node.fail("has 'count' or 'step', not both");
    const double step = node.require_in("step", 0, kMostNumber);
    if (!(step > 0) || !(to > from)) node.fail("needs a step above 0 and 'to' above 'from'");
    const double steps = std::floor((to - from) / step * (1 + 1e-12));
    if (steps >= kMostPoints) node.fail("has more than 10 million values");
    for (double i = 0; i <= steps; i += 1) values.push_back(value_text(from + i * step));
    return values;
  }
  const int count = base::get_whole_in<int>(node, "count", 0, 2, kMostPoints);
  if (count < 2) node.fail("needs 'count' (2 or more) or 'step'");
  for (int i = 0; i < count; ++i) {
    values.push_back(value_text(from + (to - from) * i / (count - 1)));
  }
  return values;
}

std::vector<std::string> parse_values(const base::ConfigNode& node) {
  std::vector<std::string> values;
  for (const base::ConfigNode& item : node.items()) {
    if (!item.is_scalar()) item.fail("is a single value: a number, a word or a file");
    const auto text = item.as<std::string>();
    if (std::ranges::find(values, text) != values.end()) item.fail("stands in the list twice");
    if (text.find_first_of("\n\r") != std::string::npos) item.fail("is a value of one line");
    values.push_back(text);
  }
  if (values.empty()) node.fail("is an empty list");
  return values;
}

constexpr Range kNumber{-kMostNumber, kMostNumber};

constexpr std::tuple kNormalKeys{
    required(key<&Distribution::mean>("mean", kNumber, "")),
    required(key<&Distribution::deviation>("deviation", Range{0, kMostNumber}, "")),
    key<&Distribution::least>("least", kNumber, ""),
    key<&Distribution::most>("most", kNumber, ""),
};

Distribution parse_normal(const base::ConfigNode& node) {
  Distribution normal{.kind = Distribution::Kind::kNormal};
  base::read_keys(node, kNormalKeys, normal);
  if (!(normal.deviation > 0)) node.at("deviation").fail("must be above 0");
  if (normal.least && normal.most && !(*normal.least < *normal.most)) {
    node.fail("'least' must be below 'most'");
  }
  return normal;
}

std::optional<Distribution> parse_distribution(const base::ConfigNode& node) {
  if (const auto uniform = node.find("uniform")) {
    const auto [least, most] = parse_ends(*uniform);
    return Distribution{.kind = Distribution::Kind::kUniform, .least = least, .most = most};
  }
  if (const auto log = node.find("log")) {
    const auto [least, most] = parse_ends(*log);
    if (!(least > 0)) log->fail("has a least value above 0: it is spread by its logarithm");
    return Distribution{.kind = Distribution::Kind::kLog, .least = least, .most = most};
  }
  if (const auto normal = node.find("normal")) return parse_normal(*normal);
  return std::nullopt;
}

std::vector<std::string> parse_keys(const base::ConfigNode& node) {
  std::vector<std::string> keys;
  if (node.is_list()) {
    keys = node.as<std::vector<std::string>>();
  } else {
    keys.push_back(node.as<std::string>());
  }
  if (keys.empty()) node.fail("is an empty list");
  for (const std::string& key : keys) {
    try {
      parse_key_path(key);
    } catch (const base::ConfigError& error) {
      node.fail(error.what());
    }
  }
  return keys;
}

Parameter parse_parameter(const base::ConfigNode& node) {
  Parameter parameter;
  parameter.keys = parse_keys(node.at("key"));
  parameter.name = node.get<std::string>("name", parameter.keys.front());
  if (!is_plain_name(parameter.name)) {
    node.fail("its name '" + parameter.name + "' is made of letters, digits and _ . - [ ]");
  }
  constexpr std::array<std::string_view, 5> kKinds{"values", "range", "uniform", "log", "normal"};
  const auto kinds =
      std::ranges::count_if(kKinds, [&node](std::string_view kind) { return node.has(kind); });
  if (kinds != 1) node.fail("has one of values, range, uniform, log and normal");
  parameter.distribution = parse_distribution(node);
  if (const auto values = node.find("values")) parameter.values = parse_values(*values);
  if (const auto range = node.find("range")) parameter.values = parse_range(*range);
  parameter.whole = node.get("whole", false);
  if (parameter.whole && !parameter.distribution) {
    node.at("whole").fail("is about values that are drawn");
  }
  return parameter;
}

constexpr Words<Sampling, 3> kSamplings{{{{"random", Sampling::kRandom},
                                          {"latin_hypercube", Sampling::kLatinHypercube},
                                          {"sobol", Sampling::kSobol}}},
                                        "is random, latin_hypercube or sobol"};

Sampling parse_sampling(const base::ConfigNode& root, const std::vector<Parameter>& parameters) {
  const bool drawn = std::ranges::any_of(
      parameters, [](const Parameter& each) { return each.distribution.has_value(); });
  const std::optional<base::ConfigNode> node = root.find("sampling");
  if (!node) {
    if (drawn) {
      root.fail(
          "has parameters with a distribution: 'sampling' says how their points are chosen "
          "(random, latin_hypercube, sobol), 'points' how many there are");
    }
    return Sampling::kNone;
  }
  if (!drawn) node->fail("is for parameters with a distribution, and there is none");
  Sampling sampling{};
  kSamplings.read(*node, sampling);
  return sampling;
}

/// `seeds: [1, 2]`, `{first: 1, count: 5}` or `{first: 1, each: row}`.
void parse_seeds(const base::ConfigNode& root, Study& study) {
  const std::optional<base::ConfigNode> node = root.find("seeds");
  if (!node) return;
  if (const auto each = node->is_map() ? node->find("each") : std::nullopt) {
    if (each->as<std::string>() != "row" || node->has("count")) {
      node->fail("is a list, {first: 1, count: 5}, or {first: 1, each: row}");
    }
    study.row_seed = node->get<std::uint64_t>("first", 1);
    return;
  }
  study.seeds = parse_seed_list(*node);
}

constexpr Words<Share, 3> kShares{
    {{{"up", Share::kUp}, {"passed", Share::kPassed}, {"judged", Share::kJudged}}},
    "is up, passed or judged"};

constexpr std::tuple kLimitKeys{
    required(key<&ShareLimit::share>("share", kShares, "")),
    required(key<&ShareLimit::at_least>("at_least", Range{0, 1}, "")),
    key<&ShareLimit::confidence>("confidence", Range{0.5, 0.999999}, ""),
};

}  // namespace

bool is_plain_name(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_.[]-").find(static_cast<char>(c)) != std::string_view::npos;
  });
}

/// Columns of one table differ by more than the case of their letters: SQLite's do.
std::vector<Parameter> parse_parameters(const base::ConfigNode& root) {
  std::vector<Parameter> parameters;
  std::set<std::string> names{"row", "point", "seed"};
  for (const base::ConfigNode& node : root.at("vary").items()) {
    parameters.push_back(parse_parameter(node));
    if (!names.insert(base::lower(parameters.back().name)).second) {
      node.fail("the name '" + parameters.back().name + "' is taken; give it another 'name'");
    }
  }
  return parameters;
}

std::vector<std::pair<std::string, std::string>> parse_settings(const base::ConfigNode& root) {
  std::vector<std::pair<std::string, std::string>> settings;
  const std::optional<base::ConfigNode> node = root.find("set");
  if (!node) return settings;
  for (const auto& [key, value] : node->entries()) {
    try {
      parse_key_path(key);
    } catch (const base::ConfigError& error) {
      value.fail(error.what());
    }
    settings.emplace_back(key, value.is_null() ? "null" : value.dump());
  }
  node->mark_used();
  return settings;
}

std::vector<std::uint64_t> parse_seed_list(const base::ConfigNode& node) {
  std::vector<std::uint64_t> seeds;
  if (node.is_list()) {
    for (const base::ConfigNode& item : node.items()) {
      const auto seed = item.as<std::uint64_t>();
      if (std::ranges::find(seeds, seed) != seeds.end()) item.fail("stands in the list twice");
      seeds.push_back(seed);
    }
    if (seeds.empty()) node.fail("is an empty list");
    return seeds;
  }
  const auto first = node.get<std::uint64_t>("first", 1);
  const int count = base::get_whole_in<int>(node, "count", 1, 1, kMostPoints);
  for (int i = 0; i < count; ++i) seeds.push_back(first + static_cast<std::uint64_t>(i));
  return seeds;
}

std::string_view to_string(Share share) { return kShares.word(share); }

double Distribution::quantile(double u) const {
  switch (kind) {
    case Kind::kUniform:
      return *least + u * (*most - *least);
    case Kind::kLog:
      return *least * std::pow(*most / *least, u);
    case Kind::kNormal:
      break;
  }
  const boost::math::normal normal(mean, deviation);
  const double low = least ? boost::math::cdf(normal, *least) : 0;
  const double high = most ? boost::math::cdf(normal, *most) : 1;
  // A bound far in the tail has a share of 0 or 1, which no value of a normal distribution has.
  const double share = std::clamp(low + u * (high - low), 1e-300, 1 - 0x1p-53);
  double value = boost::math::quantile(normal, share);
  if (least) value = std::max(value, *least);
  if (most) value = std::min(value, *most);
  return value;
}

Study Study::load(const std::filesystem::path& file) {
  const base::ConfigNode root = base::ConfigNode::load(file);
  base::expect_file(root, base::FileKind::kStudy);
  Study study;
  read_head(root, file, study);
  study.scenario = root.require<std::string>("scenario");
  study.parameters = parse_parameters(root);
  study.sampling = parse_sampling(root, study.parameters);
  if (study.sampling != Sampling::kNone) {
    root.at("points");  // says that it is missing
    study.points =
        static_cast<std::size_t>(base::get_whole_in<int>(root, "points", 1, 1, kMostPoints));
  }
  study.seed = root.get<std::uint64_t>("seed", study.seed);
  parse_seeds(root, study);
  study.settings = parse_settings(root);
  if (const auto limits = root.find("limits")) {
    for (const base::ConfigNode& node : limits->items()) {
      base::read_keys(node, kLimitKeys, study.limits.emplace_back());
    }
  }
  root.reject_unused();
  return study;
}

std::filesystem::path Study::scenario_of(const std::filesystem::path& study_file) {
  return base::find_config(base::ConfigNode::load(study_file).at("scenario"));
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/run_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.hpp"
#include "hils/sweep/sampling.hpp"

namespace cas::hils {

namespace {

constexpr std::size_t kMostRows = 10'000'000;

/// Combinations of the parameters with values, as indices; one empty combination where there is no
/// such parameter.
class Grid {
 public:
  explicit Grid(const std::vector<Parameter>& parameters) : parameters_(parameters) {
    for (const Parameter& each : parameters) {
      if (!each.values.empty()) size_ = multiply(size_, each.values.size());
    }
  }

  std::size_t size() const { return size_; }

  /// Writes the values of one combination into the places of their parameters.
  void fill(std::size_t combination, std::vector<std::string>& values) const {
    for (std::size_t i = parameters_.size(); i-- > 0;) {
      const std::vector<std::string>& choices = parameters_[i].values;
      if (choices.empty()) continue;
      values[i] = choices[combination % choices.size()];
      combination /= choices.size();
    }
  }

  static std::size_t multiply(std::size_t a, std::size_t b) {
    if (b != 0 && a > kMostRows / b) {
      throw base::ConfigError("the study has more than 10 million runs");
    }
    return a * b;
  }

 private:
  const std::vector<Parameter>& parameters_;
  std::size_t size_ = 1;
};

/// Values of the parameters with a distribution at each point, in the order of the parameters.
std::vector<std::vector<std::string>> drawn_values(const Study& study) {
  std::vector<const Parameter*> drawn;
  std::vector<std::string> names;
  for (const Parameter& each : study.parameters) {
    if (!each.distribution) continue;
    drawn.push_back(&each);
    names.push_back(each.name);
  }
  std::vector<std::vector<std::string>> points;
  for (const std::vector<double>& u :
       unit_points(study.sampling, study.points, names, study.seed)) {
    std::vector<std::string>& values = points.emplace_back();
    for (std::size_t j = 0; j < drawn.size(); ++j) {
      const Distribution& own = *drawn[j]->distribution;
      double value = own.quantile(u[j]);
      if (drawn[j]->whole) {
        value = std::round(value);
        if (own.most && value > *own.most) value = std::floor(*own.most);
        if (own.least && value < *own.least) value = std::ceil(*own.least);
      }
      values.push_back(value_text(value));
    }
  }
  if (points.empty()) points.emplace_back();
  return points;
}

template <class Number>
Number number(const std::string& text, const std::string& place) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw base::ConfigError(place + ": '" + text + "' is no whole number");
  }
  return value;
}

constexpr std::size_t kFixedColumns = 3;

}  // namespace

RunTable RunTable::of(const Study& study, std::uint64_t scenario_seed) {
  const Grid grid(study.parameters);
  const std::vector<std::vector<std::string>> drawn = drawn_values(study);
  std::vector<std::uint64_t> seeds = study.seeds;
  if (seeds.empty()) seeds.push_back(scenario_seed);
  Grid::multiply(Grid::multiply(grid.size(), drawn.size()), seeds.size());

  RunTable table;
  for (const Parameter& each : study.parameters) table.names.push_back(each.name);
  TableRow row;
  row.values.resize(study.parameters.size());
  for (std::size_t combination = 0; combination < grid.size(); ++combination) {
    grid.fill(combination, row.values);
    for (const std::vector<std::string>& values : drawn) {
      std::size_t next = 0;
      for (std::size_t i = 0; i < study.parameters.size(); ++i) {
        if (study.parameters[i].distribution) row.values[i] = values[next++];
      }
      ++row.point;
      for (const std::uint64_t seed : seeds) {
        ++row.row;
        row.seed = study.row_seed ? *study.row_seed + row.row - 1 : seed;
        table.rows.push_back(row);
      }
    }
  }
  return table;
}

RunTable RunTable::parse(std::string_view text, const std::string& name) {
  RunTable table;
  std::size_t line = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::vector<std::string> fields = csv_fields(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const std::string place = fmt::format("{}:{}", name, ++line);
    if (line == 1) {
      if (fields.size() < kFixedColumns || fields[0] != "row") {
        throw base::ConfigError(place + ": is no table of a sweep");
      }
      table.names.assign(fields.begin() + kFixedColumns, fields.end());
      continue;
    }
    if (fields.size() != kFixedColumns + table.names.size()) {
      throw base::ConfigError(fmt::format("{}: has {} fields instead of {}", place, fields.size(),
                                          kFixedColumns + table.names.size()));
    }
    TableRow row{.row = number<std::size_t>(fields[0], place),
                 .point = number<std::size_t>(fields[1], place),
                 .seed = number<std::uint64_t>(fields[2], place)};
    row.values.assign(fields.begin() + kFixedColumns, fields.end());
    if (row.row != table.rows.size() + 1) throw base::ConfigError(place + ": a row is missing");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string RunTable::csv() const {
  std::string text = "row,point,seed";
  for (const std::string& name : names) text += "," + csv_field(name);
  text += "\n";
  for (const TableRow& row : rows) {
    text += fmt::format("{},{},{}", row.row, row.point, row.seed);
    for (const std::string& value : row.values) text += "," + csv_field(value);
    text += "\n";
  }
  return text;
}

std::pair<std::size_t, std::size_t> rows_of_chunk(std::size_t rows, std::size_t k, std::size_t n) {
  const std::size_t share = rows / n;
  const std::size_t rest = rows % n;
  const auto begin = [&](std::size_t chunk) { return chunk * share + std::min(chunk, rest); };
  return {begin(k - 1) + 1, begin(k) + 1};
}

std::string value_text(double value) {
  return fmt::format("{:.9g}", value == 0 ? 0.0 : value);  // zero has no sign
}

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (quoted) return {};
  return fields;
}

}  // namespace cas::hils

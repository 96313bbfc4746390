// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/logged_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "hils/measure/column.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kTimeStep_s = 0.001;
constexpr std::size_t kMaxSeconds = 200'000;  // two days; later seconds are not counted

/// A power of ten with so many figures of a value.
double figures_of(double value, int figures) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - (figures - 1));
  return std::max(step, std::numeric_limits<double>::min());
}

/// Five figures of the largest value: finer than any plot shows; whole numbers stay whole.
double step_of(const std::vector<double>& values, bool fine) {
  double most = 0;
  bool whole = true;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    most = std::max(most, std::abs(value));
    whole = whole && value == std::floor(value);
  }
  if (whole || most == 0) return 1;
  const double step = figures_of(most, 5);
  if (!fine) return step;
  double low = most;
  double high = -most;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  constexpr int kDoubleFigures = 14;
  if (high <= low) return step;
  return std::clamp(figures_of(high - low, 4), figures_of(most, kDoubleFigures), step);
}

}  // namespace

bool LoggedSeries::take(double t_s) {
  const auto second = static_cast<std::int64_t>(std::floor(t_s));
  if (per_second_.size() < kMaxSeconds || per_second_.contains(second)) ++per_second_[second];
  if (t_s < next_s_) return false;
  next_s_ = t_s + period_s_;
  times_s_.push_back(t_s);
  expected_ = 0;
  return true;
}

void LoggedSeries::add(std::string_view name, std::string_view unit, double value, bool fine) {
  auto field = fields_.begin() + static_cast<std::ptrdiff_t>(expected_);
  if (field == fields_.end() || field->name != name) {
    const auto [place, is_new] = places_.try_emplace(std::string(name), fields_.size());
    if (is_new) fields_.push_back({std::string(name), std::string(unit), fine, {}});
    field = fields_.begin() + static_cast<std::ptrdiff_t>(place->second);
  }
  field->values.push_back(value);
  expected_ = static_cast<std::size_t>(field - fields_.begin()) + 1;
}

void LoggedSeries::thin() {
  const auto halve = [](std::vector<double>& values) {
    for (std::size_t i = 0; 2 * i < values.size(); ++i) values[i] = values[2 * i];
    values.resize((values.size() + 1) / 2);
  };
  halve(times_s_);
  for (Field& field : fields_) halve(field.values);
  period_s_ *= 2;
}

std::size_t LoggedSeries::numbers() const {
  std::size_t sum = times_s_.size();
  for (const Field& field : fields_) sum += field.values.size();
  return sum;
}

OrderedJson LoggedSeries::json(const std::string& name) const {
  OrderedJson rates = OrderedJson::array();
  for (const auto& [second, count] : per_second_) rates.push_back({second, count});
  OrderedJson fields = OrderedJson::array();
  for (const Field& field : fields_) {
    if (field.values.size() != times_s_.size()) continue;  // an array that grew
    OrderedJson entry{{"name", field.name}};
    if (!field.unit.empty()) entry["unit"] = field.unit;
    entry["values"] = column_json(field.values, step_of(field.values, field.fine));
    fields.push_back(std::move(entry));
  }
  return {{"name", name},
          {"rates", std::move(rates)},
          {"t", column_json(times_s_, kTimeStep_s)},
          {"fields", std::move(fields)}};
}

}  // namespace cas::hils

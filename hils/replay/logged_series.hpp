// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace cas::hils {

/// 20 Hz, with room for a stamp that jitters.
inline constexpr double kSeriesPeriod_s = 0.0475;

/// One message of a log over time: how often it came in each second, and its numbers at no more
/// than a rate.
class LoggedSeries {
 public:
  explicit LoggedSeries(double period_s = kSeriesPeriod_s) : period_s_(period_s) {}

  /// Counts a message. @return whether its numbers are wanted, too: add() each, every time in the
  /// same order
  bool take(double t_s);
  /// @param fine  resolve changes, too, and not only the largest value: degrees of latitude
  void add(std::string_view name, std::string_view unit, double value, bool fine = false);

  /// Drops every second sample, and takes half as many from here on.
  void thin();
  /// Samples of fields and times that are kept.
  std::size_t numbers() const;

  nlohmann::ordered_json json(const std::string& name) const;

 private:
  struct Field {
    std::string name;
    std::string unit;
    bool fine = false;
    std::vector<double> values;
  };

  double period_s_;
  std::map<std::int64_t, int> per_second_;
  std::vector<double> times_s_;
  std::vector<Field> fields_;
  std::map<std::string, std::size_t> places_;  // of fields, by name
  std::size_t expected_ = 0;                   // place of the field that comes next
  double next_s_ = 0;
};

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/phase_check.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/suggestion.hpp"
#include "plugins/fault/expression.hpp"

namespace cas::hils {

void check_phases(const base::ConfigNode& node, const std::vector<FlightStep>& steps) {
  std::vector<std::string_view> known{"done"};
  for (const FlightStep& step : steps) known.push_back(phase_of(step));
  try {
    for (const std::string& word : sim::Expression::parse(node.as<std::string>()).phases()) {
      if (std::ranges::find(known, word) != known.end()) continue;
      node.fail("the scenario has no step '" + word + "'" + base::did_you_mean(word, known));
    }
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
}

void check_fault_phases(const base::ConfigNode& faults, const std::vector<FlightStep>& steps) {
  for (const base::ConfigNode& fault : faults.items()) {
    for (const char* const key : {"when", "until"}) {
      if (const auto condition = fault.find(key)) check_phases(*condition, steps);
    }
  }
}

}  // namespace cas::hils

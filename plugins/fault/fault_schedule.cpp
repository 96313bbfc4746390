// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/fault/fault_schedule.hpp"

#include <utility>

namespace cas::sim {

FaultSchedule::FaultSchedule(std::vector<FaultSpec> faults)
    : faults_(std::move(faults)), states_(faults_.size()), since_(faults_.size()) {}

void FaultSchedule::reset() { states_.assign(faults_.size(), State::kWaiting); }

bool FaultSchedule::begins(const FaultSpec& fault, base::SimTime now, const Facts& facts) {
  return fault.at ? now >= *fault.at : fault.when->evaluate(facts);
}

bool FaultSchedule::ends(std::size_t fault, base::SimTime now, const Facts& facts) const {
  const FaultSpec& spec = faults_[fault];
  if (spec.lasting) return now - since_[fault] >= *spec.lasting;
  return spec.until && spec.until->evaluate(facts);
}

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/run_record.hpp"

#include <algorithm>

#include "hils/measure/fault_history.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"

namespace cas::hils {

using mavlink::common::HilActuatorControls;
using mavlink::common::HilControls;

std::vector<RunRecord> records_of(const Scenario& scenario, const RunPlaces& places) {
  std::vector<RunRecord> records;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    RunRecord& record = records.emplace_back();
    record.vehicle = scenario.vehicles[i].name;
    record.system = scenario.vehicles[i].system_id;
    record.truth_csv = places.vehicles[i].truth_csv();
    record.flight_tlog = places.flight_tlog();
  }
  return records;
}

void add_vehicle_faults(const RunPlaces& places, RunRecord& record) {
  for (auto& fault : vehicle_faults(places.simulator_stats(), record.vehicle)) {
    record.faults.push_back(std::move(fault));
  }
}

std::uint32_t controls_message_id(const RunRecord& record) {
  const bool outputs = std::ranges::any_of(record.controller, [](const base::LedgerEntry& entry) {
    return entry.message_id == HilActuatorControls::kId;
  });
  return outputs ? HilActuatorControls::kId : HilControls::kId;
}

}  // namespace cas::hils

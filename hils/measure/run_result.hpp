// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// One vehicle of a run: its record, the figures and the verdict.
struct VehicleResult {
  RunRecord record;
  Measurement figures;
  Verdict verdict;
};

/// A finished run.
struct RunResult {
  std::vector<VehicleResult> vehicles;  ///< in the order of the scenario
  Verdict verdict;  ///< valid when each vehicle's is, passed when each has; sentences name them

  bool has_several() const { return vehicles.size() > 1; }
  /// Figures of the run as a whole, with the worst pace of all vehicles.
  Measurement whole() const;
};

/// Measures and judges each vehicle of a run. @throws base::ConfigError when its files cannot be
/// read
RunResult evaluate(const RunRequest& request, std::vector<RunRecord> records);

/// The verdict on several vehicles together.
Verdict judge_together(const std::vector<VehicleResult>& vehicles);

}  // namespace cas::hils

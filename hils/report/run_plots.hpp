// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hils/measure/measurement.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/report/plot.hpp"

namespace cas::hils {

/// Packets received in each second of the stamps, as a share of the nominal count in percent.
Series rate_series(const std::string& name, const std::vector<base::LedgerEntry>& ledger,
                   std::uint32_t message_id, double nominal_hz);
/// Packets of a message in each second of their own stamps.
std::map<std::int64_t, int> packets_per_second(const std::vector<base::LedgerEntry>& ledger,
                                               base::LedgerEntry::Direction direction,
                                               std::uint32_t message_id);

/// The curves of one run that a comparison draws: [HILS] Fig. 16 and 17.
struct RunCurves {
  Series sensor_rate, gps_rate, controls_rate;
  Series x, y, z, yaw;  ///< true motion from where the vehicle stood; m, rad
  Series x_reference, y_reference, z_reference;
};
RunCurves run_curves(const std::string& name, const Scenario& scenario, const RunRecord& record);

/// Title of the x axis of plots over time.
inline constexpr const char* kTimeLabel = "simulated time, s";

using NamedPlots = std::vector<std::pair<std::string, Plot>>;
/// The curves of one vehicle of a run, by short name ("rates", "position_x", ...), on simulated
/// time.
NamedPlots run_plots(const RunRecord& record, const Measurement& figures);

}  // namespace cas::hils

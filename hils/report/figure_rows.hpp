// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "hils/measure/measurement.hpp"

namespace cas::hils {

/// Cells of a table, row by row. The functions below make rows without headings.
using Rows = std::vector<std::vector<std::string>>;

/// Received rate, Hz, and its error, %, of IMU, GPS and controls: the run's, then [HILS] Table 4.
Rows rate_rows(const Measurement& figures);

/// An RMS error in each axis of kRmsAxes; dashes if the measured step was not reached.
std::vector<std::string> rms_cells(const std::optional<RmsFigures>& rms);
/// Appends figures of a delay in whole microseconds; dashes if no packet was timed.
void add_delay_cells(const DelayFigures& delay,
                     std::initializer_list<double DelayFigures::*> figures,
                     std::vector<std::string>& row);
/// RMS errors of the true position and of the estimate, if known. Then those of [HILS] Table 5 if
/// the run kept its station.
/// @param names  of the first two rows
Rows rms_rows(const Measurement& figures, const std::array<std::string, 2>& names);

/// Step, size, rise time, overshoot, settling time and integrated error of each step response.
Rows response_rows(const Measurement& figures);

/// Name, begin and end, s, of each fault of the flight; also of those that never began.
Rows fault_rows(const Measurement& figures);

/// A delay of the report.
struct DelayRow {
  DelayFigures Measurement::*figures;
  const char* text_name;  ///< in report.txt
  const char* html_name;  ///< in report.html
};
inline constexpr std::array<DelayRow, 5> kDelayRows{{
    {&Measurement::sensor_to_control, "HIL_SENSOR out -> control back",
     "sensor out to control back"},
    {&Measurement::sensor_uplink, "HIL_SENSOR to the controller", "sensor to the controller"},
    {&Measurement::controls_downlink, "control to the simulator", "control to the simulator"},
    {&Measurement::age_by_stamp, "age of the sample at use (made)",
     "age of the sample at use, since it was made"},
    {&Measurement::age_by_arrival, "age of the sample at use (arrived)",
     "age of the sample at use, since it arrived"},
}};

}  // namespace cas::hils

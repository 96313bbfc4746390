// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "hils/measure/measurement.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

/// A row: its name, then figures by their keys; a dash for one that was not measured.
Row figure_cells(const Measurement& figures, const std::string& name,
                 const std::vector<std::string>& keys);
/// [HILS] Tables 4 and 5.
Rows paper_rate_rows();
Rows paper_rms_rows();
/// Received rate, Hz, and its error, %, of IMU, GPS and controls, as in [HILS] Table 4.
Row rate_row(const Measurement& figures);

/// Keys of the RMS errors in each axis. @param block  "rms" or "rms_estimate"
std::vector<std::string> rms_keys(std::string_view block);
/// RMS errors of the true position and of the estimate, if known, as in [HILS] Table 5.
/// @param names  of the rows
Rows rms_rows(const Measurement& figures, const std::array<std::string, 2>& names);

/// Each delay: packets, median, 99 % and longest; headings first.
Rows delay_rows(const Measurement& figures);
/// The figures of each step response; headings first.
Rows response_rows(const Measurement& figures);

/// Name, begin and end, s, of each fault of a flight, also of those that never began; headings
/// first.
Rows fault_rows(const std::vector<BenchFaultScript::Span>& faults,
                const std::vector<FaultThatNeverBegan>& never_began);

}  // namespace cas::hils

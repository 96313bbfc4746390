// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/topology/topology.hpp"

namespace cas::casd {

/// One stream over one line, as the start-up check assumes or the topology limits it.
struct LineLoad {
  std::uint32_t message_id = 0;
  double hz = 0;
  double packet_bytes = 0;

  double bytes_s() const { return hz * packet_bytes; }
};

/// What the routes can be expected to send over a serial line, and whether it can carry that.
struct LineBudget {
  std::string link;
  unsigned baud = 0;            ///< of several the lowest; 0: limited by a cap alone
  double capacity_bytes_s = 0;  ///< 98 % of baud / 10, or the link's own cap
  std::vector<LineLoad> loads;

  double load_bytes_s() const;
  /// Whether a stream of a HIL run goes there: without one, its load is not known beforehand.
  bool has_streams() const;
  bool fits() const { return load_bytes_s() <= capacity_bytes_s; }
  /// The highest HIL_SENSOR rate that fits beside everything else; 0 when nothing of it is sent.
  double fitting_sensor_hz() const;
  /// The lowest usual baud rate that carries the load; 0 when none does.
  unsigned fitting_baud() const;
};

/// The budget of each link with a limited rate. Expected rates are those of a HIL run ([HILS] Table
/// 4: 500 Hz HIL_SENSOR, 5 Hz HIL_GPS; 400 Hz controls), thinned out by the routes' rate rules.
/// Where no route to a line names the streams, those without an allow list are taken to send them:
/// sensors when they come from a socket, controls when they come from another line. What a link
/// does not accept goes nowhere.
std::vector<LineBudget> line_budgets(const Topology& topology);

/// A sentence for each line that cannot carry its load, with the HIL_SENSOR rate and the baud rate
/// that would fit.
std::vector<std::string> line_budget_warnings(const Topology& topology);

/// The budgets in words, stream by stream: what `casd --check` prints.
std::string describe(const std::vector<LineBudget>& budgets);

}  // namespace cas::casd

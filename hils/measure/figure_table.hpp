// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "hils/measure/measurement.hpp"
#include "hils/scenario/figure.hpp"

namespace cas::hils {

/// A HIL message of a run. Its figures have the keys "sensor_sent", "sensor_hz", ...
struct Stream {
  std::string_view key;
  std::string_view name;  ///< in summary.json and reports
  RateFigures StreamFigures::*rate;
  double MeterReadings::*meter_hz;
};
inline constexpr std::array<Stream, 3> kStreams{
    {{"sensor", "HIL_SENSOR", &StreamFigures::sensor, &MeterReadings::sensor_hz},
     {"gps", "HIL_GPS", &StreamFigures::gps, &MeterReadings::gps_hz},
     {"controls", "HIL_CONTROLS", &StreamFigures::controls, &MeterReadings::controls_hz}}};

/// A delay of a run. Its figures have the keys "sensor_uplink_count", "sensor_uplink_p50_us", ...
struct Delay {
  std::string_view key;
  std::string_view title;
  std::string_view path;  ///< of its block in summary.json
  std::string_view meaning;
  DelayFigures Measurement::*figures;
};
inline constexpr std::array<Delay, 5> kDelays{
    {{"sensor_to_control", "delay of the loop", "latency_us.sensor_to_control",
      "from HIL_SENSOR sent to its echo received, both at the simulator",
      &Measurement::sensor_to_control},
     {"sensor_uplink", "HIL_SENSOR to the controller", "latency_us.sensor_uplink",
      "from the simulator to the controller", &Measurement::sensor_uplink},
     {"controls_downlink", "control to the simulator", "latency_us.controls_downlink",
      "from the controller to the simulator", &Measurement::controls_downlink},
     {"age_by_stamp", "age of the sample at use (made)", "age_at_use_us.by_stamp",
      "of the one that a control was computed from, since its stamp in the simulator",
      &Measurement::age_by_stamp},
     {"age_by_arrival", "age of the sample at use (arrived)", "age_at_use_us.by_arrival",
      "of the one that a control was computed from, since its arrival at the controller",
      &Measurement::age_by_arrival}}};

/// The row of a key that the table has. @throws std::logic_error
const Figure<Measurement>& figure_row(std::string_view key);

/// The tables in Markdown: key, title, unit, direction, meaning and place in summary.json, for
/// `hils run --figures` and docs/reference/config.md.
std::string figure_reference();

}  // namespace cas::hils

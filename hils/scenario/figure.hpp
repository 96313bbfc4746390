// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace cas::hils {

struct Measurement;
struct StepResponse;

/// Values of a figure that are better. Only a figure with a direction can have a limit.
enum class Better { kNeither, kUp, kDown };

/// A figure of a flight as it is shown everywhere: in summary.json, in the columns of sweeps and
/// comparisons, on the line of `hils eval`, in limits, in reports and in docs/reference/config.md.
/// @tparam Of  what it is a figure of
template <class Of>
struct Figure {
  /// What the figure covers.
  enum class Part {
    kRun,     ///< the run and its machine: differs from time to time
    kStream,  ///< packets and delays in the window of the figures
    kMotion,  ///< the measured step; there is none where the flight did not come to it
  };

  std::string key;    ///< "sensor_to_control_p99_us"
  std::string title;  ///< for people: "delay of the loop, 99 %"
  std::string unit;   ///< empty: a factor
  int digits = 4;     ///< after the point, in tables
  Better better = Better::kNeither;
  std::string meaning;
  std::function<std::optional<double>(const Of&)> get;  ///< nullopt: it was not measured
  /// In summary.json, where it is not the key: "latency_us.sensor_to_control.p99".
  std::string path{};
  Part part = Part::kRun;

  const std::string& place() const { return path.empty() ? key : path; }
  bool is_count() const { return unit == "packets"; }
};

/// All figures of a vehicle's flight. hils/measure has the table: only there is a Measurement
/// known.
const std::vector<Figure<Measurement>>& figure_table();
/// All figures of the response to a step of the reference.
const std::vector<Figure<StepResponse>>& response_table();

}  // namespace cas::hils

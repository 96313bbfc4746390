// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "base/time/clock.hpp"
#include "mavlink/common/estimator_status.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "plugins/common/ulog_file.hpp"

namespace cas::hils {

/// Converts a vehicle's MAVLink messages into PX4's topics, each as it comes.
class TelemetryUlog {
 public:
  /// @param file  outlives it
  /// @param params  that the log begins with: one is written again when it has another value
  TelemetryUlog(sim::UlogFile& file, std::uint8_t system, std::span<const sim::UlogParam> params);

  void on_packet(base::SimTime time, const mav::PacketView& packet);

 private:
  void on_estimate(base::SimTime time, const mav::PacketView& packet);
  void on_setpoint(base::SimTime time, const mav::PacketView& packet);
  void on_actuators(base::SimTime time, const mav::PacketView& packet);
  void on_state(base::SimTime time, const mav::PacketView& packet);
  void on_param(const mav::PacketView& packet);

  sim::UlogFile& file_;
  std::uint8_t system_;
  std::map<std::string, double> params_;
  mavlink::common::EstimatorStatusFlags estimator_{};  ///< the newest; nothing is valid before it
  std::string sentence_;                               ///< as far as its STATUSTEXTs have come
  bool by_motor_ = false;  ///< HIL_ACTUATOR_CONTROLS has the motors' outputs
};

}  // namespace cas::hils

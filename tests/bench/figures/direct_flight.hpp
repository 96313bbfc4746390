// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "base/time/clock.hpp"
#include "fcu/flight_controller.hpp"
#include "fcu/line/line_model.hpp"
#include "hils/virtual/virtual_controller.hpp"
#include "hils/virtual/virtual_simulator.hpp"

namespace cas::hils {

/// A flight without a scenario: the vehicle, its sensors and the disturbances.
struct DirectFlightOptions {
  std::string vehicle = "vehicles/iris_paper.yaml";
  std::string sensors = "table1";  ///< a set of config/sensors, for sensors and estimator alike
  std::uint64_t seed = 1;
  double yaw_rad = 0;             ///< of the nose at the start, from north
  double mass_factor = 1;         ///< that the controller does not know of
  double wind_m_s = 0;            ///< mean, at 20 ft, from the north
  double turbulence_w20_m_s = 0;  ///< of Dryden's model; 0: none
  fcu::LineConfig line = fcu::LineConfig::from_preset("baud_921600");
};

/// Simulator with its plugins, serial line and controller in one process on the virtual clock, with
/// its caller for a pilot: no router, no files. Commands go to the controller past the line.
class DirectFlight {
 public:
  /// @throws base::ConfigError
  explicit DirectFlight(const DirectFlightOptions& options);

  struct Truth {
    Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  ///< m, from the controller's origin
    Eigen::Vector3d v_N = Eigen::Vector3d::Zero();  ///< m/s
    double yaw_rad = 0;
    Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
  };

  /// Flies on; calls `each` after every step of the simulator (1 ms).
  void run(double seconds, const std::function<void()>& each = {});
  /// Flies on until `condition`, at most so long. @return whether it came true
  bool run_until(const std::function<bool()>& condition, double at_most_s);

  /// Waits until the controller is ready, arms, climbs. @return false when one of them never came
  bool take_off(double height_m);
  /// Goes to a place above the origin and holds it.
  void go_to(double north_m, double east_m, double up_m, double yaw_rad);
  bool set_param(std::string_view name, double value);

  Truth truth() const;
  const fcu::FlightStatus& status() const { return controller_.controller().status(); }
  const fcu::Estimator& estimator() const { return controller_.controller().estimator(); }
  /// Of truth().
  base::SimTime simulated_time() const { return simulator_->time(); }
  double time_s() const { return base::to_seconds(now_.time_since_epoch()); }

 private:
  void advance();
  template <class Message>
  void send(const Message& message);

  VirtualController controller_;
  std::unique_ptr<VirtualSimulator> simulator_;
  base::RunTime now_{};
  std::uint8_t sequence_ = 0;
};

}  // namespace cas::hils

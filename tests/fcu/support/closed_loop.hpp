// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "fcu/flight_controller.hpp"
#include "fcu/line/line_model.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/fcu/support/multirotor_sim.hpp"

namespace cas::fcu::test {

/// Sensor noise of the harness: deviations of one sample.
struct SensorNoise {
  Eigen::Vector3d gyro_rad_s = Eigen::Vector3d(0.67, 0.78, 0.12) * M_PI / 180;
  Eigen::Vector3d accel_m_s2{0.04, 0.06, 0.07};
  double gps_m = 0.3;
  double gps_velocity_m_s = 0.1;
  double baro_pa = 1.0;
  double mag_gauss = 0.004;
  Eigen::Vector3d gyro_bias_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_m_s2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d mag_bias_gauss = Eigen::Vector3d::Zero();
  Eigen::Vector3d field_error_gauss = Eigen::Vector3d::Zero();  ///< earth against its model, N
  double baro_offset_pa = 0;
  double gps_delay_s = 0;
  Eigen::Vector3d gps_offset_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d gps_velocity_offset_m_s = Eigen::Vector3d::Zero();
};

/// [HILS] Table 1, completed.
SensorNoise table1_noise();
/// RTK receiver and data-sheet IMU at 500 Hz.
SensorNoise rtk_noise();

struct LoopOptions {
  std::string vehicle = "iris_paper";
  std::optional<base::Vehicle> airframe;  ///< this one instead
  SensorNoise noise;
  std::uint64_t seed = 1;
  double mass_scale = 1;
  double yaw_rad = 0;
  LineConfig line;         ///< both directions
  double sensor_loss = 0;  ///< share of HIL_SENSOR packets that never arrive
  std::function<void(FcuConfig&)> configure;
  /// Called with all input of the controller, in order.
  std::function<void(std::span<const std::uint8_t>, base::RunTime)> tap;
};

/// Estimator noise parameters that match a sensor preset, as config/fcu files give them.
void assume(FcuConfig& config, const SensorNoise& noise);

/// Simulator, line and controller on one virtual clock.
class ClosedLoop {
 public:
  explicit ClosedLoop(const LoopOptions& options);

  /// Advances by whole milliseconds; calls `each` after every step.
  void run(double seconds, const std::function<void()>& each = {});
  /// Runs until `condition`, at most so long. @return whether it came true
  bool run_until(const std::function<bool()>& condition, double at_most_s);

  /// Sends a message to the controller, past the line; by default as a ground station.
  template <class Message>
  void send(const Message& message, mav::Source from = {255, 190}) {
    mav::PacketBuffer buffer;
    buffer.size = mav::encode(message, from, gcs_sequence_++, buffer.bytes);
    if (options_.tap) options_.tap(buffer.view(), now());
    fcu_->on_packet(mav::view_packet(buffer.view()), now());
  }
  /// Sends a COMMAND_LONG. @return the result acknowledged at once
  mavlink::common::MavResult command(mavlink::common::MavCmd id, std::array<float, 7> params = {});

  bool arm();
  bool take_off(double height_m);
  /// Waits for the estimator, arms and climbs; false when something is refused or never comes.
  bool fly_to_hover(double height_m = 2.5);
  /// Re-positions in Hold.
  void go_to(double north_m, double east_m, double up_m, float yaw_rad = NAN);

  /// The controller's configuration.
  const FcuConfig& config() const { return config_; }
  FlightController& fcu() { return *fcu_; }
  MultirotorSim& multirotor() { return multirotor_; }
  SensorNoise& noise() { return options_.noise; }
  const MultirotorSim::State& truth() const { return multirotor_.state(); }
  double yaw() const;
  base::RunTime now() const { return base::RunTime(time_.time_since_epoch()); }
  double time_s() const { return base::to_seconds(time_); }
  const base::Geodetic& home() const { return home_; }

  bool gps_on = true, mag_on = true, baro_on = true, imu_on = true;
  bool gps_frozen = false;       ///< the last fix again, with a new stamp
  bool gps_time_stands = false;  ///< new fixes with the last stamp
  bool gyro_stuck = false, accel_stuck = false;

  /// Packets from the controller of one message, newest last.
  template <class Message>
  std::vector<Message> received() const {
    std::vector<Message> out;
    for (const auto& packet : from_fcu_) {
      if (const auto m = mav::decode<Message>(mav::view_packet(packet))) out.push_back(*m);
    }
    return out;
  }
  void forget_packets() { from_fcu_.clear(); }
  std::vector<std::string> texts() const;
  bool said(const std::string& part) const;
  /// Keeps telemetry for received(); off by default for HIL answers, they are many.
  bool keep_packets = true;
  std::uint64_t controls_received = 0;

 private:
  void sense();
  void on_fcu_bytes(std::span<const std::uint8_t> bytes);
  void on_answer(const mav::PacketView& packet);
  void move_lines();
  template <class Message>
  void to_fcu(const Message& message);

  LoopOptions options_;
  FcuConfig config_;
  base::Vehicle vehicle_;
  base::Geodetic home_{47.397742, 8.545594, 488.0};
  base::LocalProjection projection_;
  Eigen::Vector3d field_N_;
  MultirotorSim multirotor_;
  base::NormalRandom imu_random_, gps_random_, mag_random_, baro_random_, loss_random_;
  std::unique_ptr<LineModel> up_, down_;
  std::unique_ptr<FlightController> fcu_;
  mav::PacketParser answers_;
  mav::Encoder sim_encoder_{{1, 200}};
  base::SimTime time_{};
  std::int64_t steps_ = 0;
  Eigen::Vector3d force_before_D_ = Eigen::Vector3d::Zero();
  mavlink::common::HilGps last_fix_;
  Eigen::Vector3d last_rate_D_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_measured_force_D_ = Eigen::Vector3d::Zero();
  std::uint8_t gcs_sequence_ = 0;
  std::vector<std::vector<std::uint8_t>> from_fcu_;
  struct LateFix {
    base::SimTime due;
    std::vector<std::uint8_t> packet;
  };
  std::vector<LateFix> late_fixes_;
};

}  // namespace cas::fcu::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "fcu/flight_controller.hpp"
#include "mavlink/common/all.hpp"
#include "tests/firmware/scripted_fence.hpp"
#include "tests/firmware/scripted_px4.hpp"

namespace cas::test {

/// Values that ArduPilot's parser reads from a simulator's line.
struct ParsedJson {
  double timestamp = 0;
  std::array<double, 3> gyro{};
  std::array<double, 3> accel{};
  std::array<double, 3> position{};
  std::array<double, 3> velocity{};
  std::array<double, 4> quaternion{};
};

/// Reads as picky as ArduPilot: keys by substring, '[' directly behind the colon, a newline at
/// either end. @return the values; nullopt with a complaint
std::optional<ParsedJson> parse_as_ardupilot(std::string_view text, std::string& complaint);

/// Stand-in for ArduCopter in the tests: its packets, its parser, its modes and commands; our own
/// controller does the flying. No I/O and no clock.
class ScriptedArdupilot {
 public:
  struct Options {
    int channels = 16;  ///< 32: SERVO_32_ENABLE
    std::uint16_t frame_rate_hz = 1200;
    std::string vehicle = "iris_px4";
    /// Until then it arms, refuses GUIDED and disarms itself after 10 s: ArduCopter 4.5.6 was armed
    /// 25 s after its start and had its position after 45 s.
    base::Duration position_after{};
    std::uint8_t system = 1;  ///< SYSID_THISMAV, by --sysid
    /// At its own fence.
    FenceManner fence = FenceManner::kKeeps;
  };

  ScriptedArdupilot(const Options& options, Channel::Send to_ground);

  /// The current packet: the same again until an answer has arrived.
  std::vector<std::uint8_t> servo_packet() const;
  /// An answer: the next packet is due. @return false when it cannot be read
  bool on_text(std::string_view text);
  void on_ground_bytes(std::span<const std::uint8_t> bytes);

  /// Time since the first answer.
  base::RunTime clock() const { return base::RunTime(time_); }
  std::uint32_t frame_count() const { return frame_count_; }
  void skip_packets(std::uint32_t count) { frame_count_ += count; }
  const std::string& complaint() const { return complaint_; }
  const std::optional<ParsedJson>& newest() const { return newest_; }
  /// Mean pulse width of the motors while it hovered.
  double mean_pwm_us() const { return pwm_samples_ > 0 ? pwm_sum_ / pwm_samples_ : 0; }
  void clear_mean() { pwm_sum_ = pwm_samples_ = 0; }

 private:
  void feed_controller();
  bool is_early() const { return time_ < options_.position_after; }
  bool is_armed_early() const;
  void say_ekf_report(const mavlink::common::EstimatorStatus& status);
  void note_wish(const mavlink::common::CommandLong& command);
  bool is_unasked(std::uint32_t message_id);
  void on_controller_packet(std::span<const std::uint8_t> bytes);
  bool on_command(const mavlink::common::CommandLong& command, mav::Source from);
  bool set_mode(const mavlink::common::CommandLong& command, mav::Source from);
  bool start_mission(const mavlink::common::CommandLong& command, mav::Source from);
  bool may_fly_mission();
  void fly_mission();
  bool on_setpoint(const mav::PacketView& packet);
  void watch_fence(const mav::PacketView& packet);
  void hold();
  void loiter();
  void land();
  void say(const std::string& text,
           mavlink::common::MavSeverity severity = mavlink::common::MavSeverity::kCritical);
  void acknowledge(const mavlink::common::CommandLong& command, mav::Source to,
                   mavlink::common::MavResult result);
  void pass_on(mavlink::common::CommandLong command);
  std::uint16_t pwm_us(int motor) const;

  Options options_;
  Channel ground_;
  fcu::FlightController controller_;
  base::LocalProjection projection_;
  mav::PacketParser from_ground_{mavlink::common::table()};
  mav::Encoder into_controller_{{1, 200}};
  ScriptedFence fence_;
  std::optional<Eigen::Vector3d> home_N_;  // where it was armed
  mav::Encoder as_ground_{{254, 190}};
  std::uint32_t frame_count_ = 0;
  base::Duration time_{};
  double first_timestamp_ = 0;
  std::optional<ParsedJson> newest_;
  std::array<float, 4> motors_{};
  bool armed_ = false;
  std::optional<base::Duration> armed_early_at_;
  std::set<std::uint32_t> streams_;  // that somebody has asked for
  std::set<std::uint32_t> wishes_;   // messages that somebody has asked for once
  bool arming_ = false;              // wish of the last arm or disarm command
  std::uint32_t mode_ = 0;           // STABILIZE
  bool follows_setpoints_ = false;   // in GUIDED
  base::Duration newest_setpoint_{};
  std::size_t items_ = 0;  // of its mission, with home
  bool begins_with_takeoff_ = false;
  std::string complaint_;
  base::NormalRandom noise_{1};
  double pwm_sum_ = 0;
  double pwm_samples_ = 0;
};

}  // namespace cas::test

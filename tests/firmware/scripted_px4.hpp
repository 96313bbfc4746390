// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "fcu/flight_controller.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/firmware/scripted_fence.hpp"

namespace cas::test {

/// The two generations of PX4 whose behaviour on the wire is scripted.
enum class Px4Release { k1_12, k1_16 };

/// How PX4 is tied to its simulator: the simulator API over TCP with the simulator's clock, or a
/// serial line in HITL mode with a clock of its own.
enum class Px4Mode { kSitl, kHitl };

/// Behaviour that no firmware has: it reports one thing and does another.
enum class Px4Lie {
  kNone,
  kSkipsWaypoints,    ///< takes home for the place of each waypoint of a mission but the last
  kIgnoresSetpoints,  ///< hangs at the first one in OFFBOARD
  kLandsInWords,      ///< accepts a landing, says that it is on the ground, and stays in the air
  kReturnsInWords,    ///< lands where it is instead of at home, and says that it is at home
};

/// Packets as one channel of PX4 sends them: each with the next sequence number.
class Channel {
 public:
  using Send = std::function<void(std::span<const std::uint8_t>)>;
  explicit Channel(Send send, std::uint8_t system = 1) : self_{system, 1}, send_(std::move(send)) {}

  template <class Message>
  void send(const Message& message) {
    std::array<std::uint8_t, mav::kMaxPacketBytes> bytes;
    const std::size_t size = mav::encode(message, self_, sequence_++, bytes);
    send_(std::span(bytes).first(size));
  }
  /// A packet with a sequence number of another sender.
  void forward(std::span<const std::uint8_t> packet);
  /// A message that our dialect does not have.
  void send_foreign(std::uint32_t message_id, std::uint8_t crc_extra,
                    std::span<const std::uint8_t> payload);

 private:
  mav::Source self_;
  Send send_;
  std::uint8_t sequence_ = 0;
};

/// Stand-in for PX4 in the tests: its connection, its order of messages, its pickiness and its
/// answers, as observed of stock PX4; our own controller does the flying. No I/O and no clock:
/// bytes and time come in, bytes go out.
class ScriptedPx4 {
 public:
  struct Options {
    Px4Release release = Px4Release::k1_16;
    Px4Mode mode = Px4Mode::kSitl;
    /// SITL: asks for HIL_STATE_QUATERNION when it has connected, as v1.12.0 and v1.16.1 do.
    bool asks_for_truth = true;
    /// SITL: HIL_SENSORs until the first answer (17 to 96 were seen).
    int boot_samples = 40;
    /// SITL: until then it says that it has a position, accepts arming and refuses to take off.
    base::RunTime takes_off_after{};
    /// SITL: accepts arming and takeoff, and stays on the ground until it has disarmed itself once.
    bool stays_at_first = false;
    /// SITL: an armed vehicle that does not take off disarms itself after this time (v1.12.0).
    base::Duration disarms_itself_after = std::chrono::seconds(8);
    /// Ignores setpoints from this long after the first on (v1.16.1: COM_OF_LOSS_T later OFFBOARD
    /// is over).
    std::optional<base::Duration> loses_setpoints_after{};
    /// Aborts this long after arming.
    std::optional<base::Duration> dies_after{};
    /// Says in its HEARTBEAT that it flies a plane.
    bool is_plane = false;
    /// Says in it that it is ArduPilot.
    bool is_ardupilot = false;
    /// Reports flights that it has not flown.
    Px4Lie lie = Px4Lie::kNone;
    /// At its own fence.
    FenceManner fence = FenceManner::kKeeps;
    std::string vehicle = "iris_px4";
    std::uint8_t system = 1;  ///< of instance N: N + 1
  };

  /// @param to_simulator  bytes of the simulator's connection
  /// @param to_ground  bytes of the ground station's link; in HITL both are one line
  ScriptedPx4(const Options& options, Channel::Send to_simulator, Channel::Send to_ground);

  /// SITL: PX4's first messages after connect() has succeeded.
  void on_connected();
  void on_simulator_bytes(std::span<const std::uint8_t> bytes, base::RunTime now);
  void on_ground_bytes(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// HITL: streams on PX4's own clock.
  void tick(base::RunTime now);

  /// PX4's clock: in SITL the stamp of the newest HIL_SENSOR.
  base::RunTime clock() const { return clock_; }
  std::uint64_t samples() const { return samples_; }
  std::uint64_t answers() const { return answers_; }
  std::uint64_t fixes() const { return fixes_; }
  /// Complaints that stock PX4 would raise, in its words.
  const std::vector<std::string>& complaints() const { return complaints_; }
  const fcu::FlightController& controller() const { return controller_; }
  /// Restores params_text() of an earlier program's controller.
  void restore_params(const std::string& lines);
  const mavlink::common::HilSensor& newest_sample() const { return sensor_; }
  const std::optional<mavlink::common::HilGps>& newest_fix() const { return gps_; }
  /// The true motion that it logs, and how often it has come.
  const std::optional<mavlink::common::HilStateQuaternion>& newest_truth() const { return truth_; }
  std::uint64_t truths() const { return truths_; }

 private:
  /// Counts bit-identical values of one sensor, as PX4's data validator does.
  struct Staleness {
    std::uint64_t digest = 0;
    int repeats = 0;
    bool seen = false;
  };

  void on_sensor_packet(const mav::PacketView& packet, base::RunTime now);
  void on_sample(const mavlink::common::HilSensor& sample, base::RunTime now);
  void on_fix(const mavlink::common::HilGps& fix, base::RunTime now);
  void on_truth(const mavlink::common::HilStateQuaternion& truth);
  void answer_sample();
  void on_controller_packet(std::span<const std::uint8_t> bytes);
  bool answers_its_own_way(const mav::PacketView& packet);
  bool refuse_to_arm(const mavlink::common::CommandLong& command, mav::Source from);
  bool arm_early(const mavlink::common::CommandLong& command, mav::Source from);
  bool disarm_early(const mavlink::common::CommandLong& command, mav::Source from);
  void disarm_in_time();
  void die_in_time();
  void disarm(const char* by);
  bool say_who_disarmed(const mav::PacketView& packet);
  void acknowledge(mavlink::common::MavCmd command, mav::Source to,
                   mavlink::common::MavResult result);
  bool lacks_position() const;
  bool refuses_takeoff() const;
  bool loses(const mav::PacketView& packet);
  bool twists(const mav::PacketView& packet);
  bool lies(const mav::PacketView& packet);
  bool say_v1_12(const mav::PacketView& packet);
  bool say_v1_16(const mav::PacketView& packet);
  void note_readiness(const mav::PacketView& packet);
  std::string preflight_failure() const;
  void look_for_repeats(Staleness& sensor, std::span<const float> values, int most,
                        const char* complaint);
  void watch_fence(const mav::PacketView& packet);
  void hold_return_or_land(ScriptedFence::Action action);
  void watch_gap(base::RunTime now);
  bool stays_armed() const;
  mavlink::common::Heartbeat in_software(mavlink::common::Heartbeat heartbeat) const;
  void complain(const std::string& text);
  void say(const std::string& text, mavlink::common::MavSeverity severity);
  mavlink::common::HilActuatorControls outputs(base::RunTime now) const;

  Options options_;
  Channel simulator_;
  Channel ground_;
  fcu::FlightController controller_;
  mav::PacketParser from_simulator_{mavlink::common::table()};
  mav::PacketParser from_ground_{mavlink::common::table()};
  mav::Encoder sensors_in_{{1, 200}};
  mav::Encoder as_itself_;
  ScriptedFence fence_;

  base::RunTime clock_{};
  std::uint64_t samples_ = 0;
  std::uint64_t answers_ = 0;
  std::uint64_t fixes_ = 0;
  base::RunTime last_answer_{};
  base::RunTime last_sample_at_{};
  bool stream_lost_ = false;
  mavlink::common::HilSensor sensor_;
  std::optional<mavlink::common::HilGps> gps_;
  std::optional<mavlink::common::HilStateQuaternion> truth_;
  std::uint64_t truths_ = 0;
  Staleness mag_;
  Staleness baro_;
  std::array<float, 4> motors_{};
  bool armed_ = false;
  bool ready_ = false;  // its checks let one arm, as of its newest SYS_STATUS
  std::uint16_t text_id_ = 0;
  std::optional<base::RunTime> armed_early_at_;
  std::optional<base::RunTime> first_setpoint_at_;
  std::optional<base::RunTime> armed_at_;
  bool has_disarmed_itself_ = false;
  std::optional<Eigen::Vector3d> home_N_;  // where it was armed
  bool in_air_ = false;
  bool comes_down_ = false;  // for a gap in its sensors
  bool terminated_ = false;
  std::optional<mavlink::common::SetPositionTargetLocalNed> first_setpoint_;
  int mission_items_ = 0;
  bool lies_now_ = false;
  std::vector<std::string> complaints_;
};

}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/measure/ledger.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/mavlink_message.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/odometry_sample.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/hil_state_quaternion.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message_table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/sequence_tracker.hpp"
#include "mavlink_gen/services/failure_order.hpp"
#include "plugins/common/terrain_requests.hpp"
#include "plugins/mavlink_interface/failure_map.hpp"
#include "plugins/mavlink_interface/hil_port.hpp"
#include "plugins/mavlink_interface/servo_map.hpp"

namespace cas::sim {

struct HilInterfaceParams {
  mav::Source self{1, 200};
  base::ControlScales scales;
  double heartbeat_hz = 1;
  double control_rate_hz = 400;       ///< lockstep: a control is due when floor(t * rate) advances
  base::Duration actuator_timeout{};  ///< silence after which the rotors stop
  /// PX4's simulator API: a controller is waited for from its first answer on, and then answers
  /// each HIL_SENSOR. Else it is waited for from the start, by `control_rate_hz`.
  bool joins_by_answering = false;
  /// Takes SERVO_OUTPUT_RAW, as a stock ArduPilot sends it, which has its sensors elsewhere (plugin
  /// external_ahrs): HIL_SENSOR and HIL_GPS are not sent then.
  std::optional<ServoMap> servos{};
  /// Added to simulated time on the wire.
  base::Duration wire_epoch{};
  /// How often a controller that `joins_by_answering` has asked for HIL_STATE_QUATERNION so far.
  double truth_hz = 0;
};

/// The stamps that were sent last: whether a controller answers them, or tells a clock of its own.
class RecentStamps {
 public:
  void add(std::uint64_t stamp) { stamps_[next_++ % stamps_.size()] = stamp; }
  bool contains(std::uint64_t stamp) const {
    return stamp != 0 && std::find(stamps_.begin(), stamps_.end(), stamp) != stamps_.end();
  }
  void clear() { stamps_.fill(0); }

 private:
  std::array<std::uint64_t, 512> stamps_{};  // two seconds at 250 Hz
  std::size_t next_ = 0;
};

/// Counts packets by message id; allocates only when an id is new.
class MessageCounts {
 public:
  void add(std::uint32_t id);
  std::uint64_t of(std::uint32_t id) const;
  nlohmann::ordered_json json() const;  ///< {"HIL_SENSOR":500,...}

 private:
  std::vector<std::pair<std::uint32_t, std::uint64_t>> counts_;
};

/// The simulator's end of the wire: sensors out, actuator commands in.
///
///   on_imu, on_gps, ... --> flush() --> port        once per step, newest of each
///   port --> receive() --> on_packet --> take_command()
class HilInterface {
 public:
  /// @param ledger  remembers HIL packets; may be null. Port and ledger must outlive the object.
  HilInterface(const HilInterfaceParams& params, HilPort& port, base::PacketLedger* ledger);
  HilInterface(const HilInterface&) = delete;
  HilInterface& operator=(const HilInterface&) = delete;

  // @param at  of several of a kind, from 0: the `id` that it has on the wire
  void on_imu(const ImuSample& sample, std::size_t at = 0) {
    take(sets_.at(at).imu, sample, kPartImu, at);
  }
  void on_gps(const GpsSample& sample, std::size_t at = 0) {
    take(gps_.at(at), sample, kPartGps, at);
  }
  void on_magnetometer(const MagnetometerSample& sample, std::size_t at = 0) {
    take(sets_.at(at).magnetometer, sample, kPartMagnetometer, at);
  }
  void on_barometer(const BarometerSample& sample, std::size_t at = 0) {
    take(sets_.at(at).barometer, sample, kPartBarometer, at);
  }
  void on_airspeed(const AirspeedSample& sample, std::size_t at = 0) {
    take(airspeed_, sample, kPartAirspeed, at);
  }
  void on_range(const RangeSample& sample, std::size_t at = 0) {
    take(range_.at(at), sample, kPartRangefinder, at);
  }
  /// Notes that the sensor reports; plugin odometry makes the message itself.
  void on_odometry(const OdometrySample&, std::size_t at = 0) { sensors_.add(kPartOdometry, at); }
  void on_battery(const BatterySample& sample) { battery_ = sample; }
  void on_esc(const EscSample& sample) { esc_ = sample; }
  /// A message of a plugin, for the next flush(). @return false when too many wait already
  bool on_message(const mav::MessageInfo& info, const MavlinkMessage& message);

  /// Handles MAV_CMD_INJECT_FAILURE for the simulator itself and returns the result. Without a
  /// handler no failure can be injected.
  struct FailureAnswer {
    mavlink::common::MavResult result{};
    mav::services::FailureRefusal why{};
  };
  using OnFailure = std::function<FailureAnswer(const mav::services::FailureOrder&)>;
  void on_failure(OnFailure callback) { on_failure_ = std::move(callback); }
  /// Whether the controller is to have the true motion in this step. One that `joins_by_answering`
  /// asks for it by MAV_CMD_SET_MESSAGE_INTERVAL, and records it; in HITL PX4 would fly by it, and
  /// does not get it. At most 250 Hz, and only together with a HIL_SENSOR.
  bool truth_due(base::SimTime now) { return clock() && truth_due_.due(now); }
  void on_truth(const mavlink::common::HilStateQuaternion& truth) { truth_ = truth; }
  /// Sends a grid that the controller has requested, if one is due.
  void send_terrain(base::SimTime now, const TerrainSource::Elevation& elevation_m);
  /// Current rate of the ground truth; 0: off.
  double truth_hz() const { return truth_due_.rate_hz(); }
  /// The sensors that have spoken.
  const SpokenSensors& sensors() const { return sensors_; }

  /// Sends new data: HEARTBEAT when due, answers to commands, messages of plugins, BATTERY_STATUS,
  /// ESC_STATUS (and ESC_INFO once a second), DISTANCE_SENSOR, HIL_GPS, HIL_SENSOR (with each IMU
  /// sample).
  ///
  /// The HIL_SENSOR of id 0 is the clock: it is sent with a sample of any IMU, and if the first IMU
  /// has none, without its bits. Those of further ids carry what is new of their sensors; before
  /// the clock, so that the answer knows them, and behind it for a controller that
  /// `joins_by_answering`, because PX4 stamps them by the clock that it has then.
  void flush(base::SimTime now);

  /// Reads all waiting input of the port.
  void receive();
  /// The newest command since the last call; after `actuator_timeout` of silence one that stops
  /// the rotors; else nothing.
  std::optional<MotorCommand> take_command(base::SimTime now);

  /// Whether the controls that are due for the sensors sent so far have arrived (lockstep).
  bool answered() const { return answered_usec_ >= due_usec_; }
  /// Stops waiting for answers to sensors sent so far.
  void give_up();
  /// Whether a controller answers; without one lockstep does not wait.
  bool in_step() const { return in_step_; }
  /// Stamp of the newest sent HIL_SENSOR, on the wire's clock.
  base::Duration wire_end() const { return std::chrono::microseconds(sent_usec_); }
  /// Whether the last packet sent was a HIL_SENSOR and its answer is here: nothing is in flight.
  bool settled() const { return !on_its_way_; }

  const MessageCounts& sent() const { return sent_; }
  const MessageCounts& received() const { return received_; }
  std::uint64_t actuator_timeouts() const { return actuator_timeouts_; }
  nlohmann::ordered_json figures() const;

 private:
  /// A message that waits for the next flush().
  struct Waiting {
    const mav::MessageInfo* info;
    MavlinkMessage message;
  };

  /// What one HIL_SENSOR carries beside the airspeed.
  struct SensorSet {
    std::optional<ImuSample> imu;
    std::optional<MagnetometerSample> magnetometer;
    std::optional<BarometerSample> barometer;
    mavlink::common::HilSensor packet;  ///< repeats the last value of each field

    bool is_new() const { return imu || magnetometer || barometer; }
  };

  template <class Sample>
  void take(std::optional<Sample>& newest, const Sample& sample, VehiclePart part, std::size_t at) {
    newest = sample;
    sensors_.add(part, at);
  }
  /// Time of the newest IMU sample that waits to be sent: the first IMU's, if it has one.
  std::optional<base::SimTime> clock() const;
  template <class Message>
  bool send(const Message& message);
  bool send_packet(std::uint32_t id, std::size_t size);
  void send_messages();
  void look_for_new_peer();
  void join();
  void send_heartbeat(base::SimTime now);
  void forget_sensors();
  void send_escs();
  void send_gps();
  void send_sensors(base::SimTime clock);
  void send_further_sensors(std::uint64_t time_usec);
  void fill_set(SensorSet& set);
  void watch_first_imu(bool speaks, std::uint64_t time_usec);
  void leave_step(std::uint64_t time_usec);
  void send_clock(std::uint64_t time_usec);
  void on_packet(const mav::PacketView& packet, base::RunTime at);
  void on_command(const mav::PacketView& packet);
  void on_interval(const mavlink::common::CommandLong& command);
  void on_failure_command(const mavlink::common::CommandLong& command,
                          const mav::PacketView& packet);
  template <class Controls>
  void on_controls(const Controls& controls, const MotorCommand& command, base::RunTime at);

  HilInterfaceParams params_;
  HilPort& port_;
  base::PacketLedger* ledger_;
  HilPort::OnBytes on_bytes_;

  // Out.
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet_{};
  std::uint8_t sequence_ = 0;
  base::RateGate heartbeat_;
  bool announced_ = false;
  std::uint64_t peers_;            // of the port, that were greeted
  std::array<SensorSet, 3> sets_;  // by id
  std::array<std::optional<GpsSample>, 2> gps_;
  std::optional<AirspeedSample> airspeed_;
  std::array<std::optional<RangeSample>, 2> range_;
  std::optional<BatterySample> battery_;
  std::optional<EscSample> esc_;
  std::uint16_t escs_sent_ = 0;
  base::RateGate esc_info_{1};
  std::optional<mavlink::common::HilStateQuaternion> truth_;
  base::RateGate truth_due_;
  TerrainRequests terrain_;
  std::vector<Waiting> waiting_;
  SpokenSensors sensors_;
  OnFailure on_failure_;
  std::vector<mavlink::common::CommandAck> answers_;  // wait for the next flush()

  // In.
  mav::PacketParser parser_;
  mav::SequenceTracker sequences_;
  std::optional<MotorCommand> command_;
  std::optional<base::SimTime> last_command_;  // nullopt: silent, rotors stopped
  std::uint64_t overwritten_commands_ = 0;
  std::uint64_t actuator_timeouts_ = 0;

  // Lockstep.
  bool in_step_;
  RecentStamps stamps_;
  bool first_imu_silent_ = false;
  std::uint64_t joins_from_usec_ = 0;  // not before, while the first IMU is silent
  base::RateGate control_due_;
  std::uint64_t sent_usec_ = 0;      // newest HIL_SENSOR
  std::uint64_t due_usec_ = 0;       // newest HIL_SENSOR that is to be answered
  std::uint64_t answered_usec_ = 0;  // newest echo
  bool on_its_way_ = false;          // something was sent since the last answered HIL_SENSOR
  bool sensor_sent_last_ = false;

  MessageCounts sent_;
  MessageCounts received_;
};

}  // namespace cas::sim

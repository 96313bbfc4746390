// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/ledger.hpp"
#include "base/rate_gate.hpp"
#include "base/vehicle.hpp"
#include "libsim/api/messages.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/sequence_tracker.hpp"
#include "plugins/mavlink_interface/packet_port.hpp"

namespace cas::sim {

struct HilInterfaceParams {
  mav::Source self{1, 200};
  base::ControlScales scales;
  double heartbeat_hz = 1;
  double control_rate_hz = 400;       ///< lockstep: a control is due when floor(t * rate) advances
  base::Duration actuator_timeout{};  ///< silence after which the rotors stop
};

/// Counts packets by message id; allocates only when an id is new.
class MessageCounts {
 public:
  void add(std::uint32_t id);
  std::uint64_t of(std::uint32_t id) const;
  std::string json() const;  ///< {"HIL_SENSOR":500,...}

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
  HilInterface(const HilInterfaceParams& params, PacketPort& port, base::PacketLedger* ledger);
  HilInterface(const HilInterface&) = delete;
  HilInterface& operator=(const HilInterface&) = delete;

  void on_imu(const ImuSample& sample) { imu_ = sample; }
  void on_gps(const GpsSample& sample) { gps_ = sample; }
  void on_magnetometer(const MagnetometerSample& sample) { magnetometer_ = sample; }
  void on_barometer(const BarometerSample& sample) { barometer_ = sample; }
  void on_range(const RangeSample& sample) { range_ = sample; }

  /// Sends what is new: HEARTBEAT when due, DISTANCE_SENSOR, HIL_GPS, HIL_SENSOR (with each IMU
  /// sample).
  void flush(base::SimTime now);

  /// Reads what the port has.
  void receive();
  /// The newest command since the last call; after `actuator_timeout` of silence one that stops
  /// the rotors; else nothing.
  std::optional<MotorCommand> take_command(base::SimTime now);

  /// Whether the controls that are due for the sensors sent so far have arrived (lockstep).
  bool answered() const { return answered_usec_ >= due_usec_; }

  const MessageCounts& sent() const { return sent_; }
  const MessageCounts& received() const { return received_; }
  std::uint64_t actuator_timeouts() const { return actuator_timeouts_; }
  std::string stats_json() const;

 private:
  template <class Message>
  bool send(const Message& message);
  void send_heartbeat(base::SimTime now);
  void send_gps();
  void send_sensor();
  void on_packet(const mav::PacketView& packet, base::RunTime at);
  template <class Controls>
  void on_controls(const Controls& controls, const MotorCommand& command, base::RunTime at);

  HilInterfaceParams params_;
  PacketPort& port_;
  base::PacketLedger* ledger_;
  PacketPort::OnBytes on_bytes_;

  // Out.
  mav::Encoder encode_;
  base::RateGate heartbeat_;
  bool announced_ = false;
  std::optional<ImuSample> imu_;
  std::optional<GpsSample> gps_;
  std::optional<MagnetometerSample> magnetometer_;
  std::optional<BarometerSample> barometer_;
  std::optional<RangeSample> range_;
  mavlink::common::HilSensor sensor_;  // keeps the last value of what is not new

  // In.
  mav::PacketParser parser_;
  mav::SequenceTracker sequences_;
  std::optional<MotorCommand> command_;
  std::optional<base::SimTime> last_command_;  // nothing: silent, rotors stopped
  std::uint64_t overwritten_commands_ = 0;
  std::uint64_t actuator_timeouts_ = 0;

  // Lockstep.
  base::RateGate control_due_;
  std::uint64_t sent_usec_ = 0;      // newest HIL_SENSOR
  std::uint64_t due_usec_ = 0;       // newest HIL_SENSOR that is to be answered
  std::uint64_t answered_usec_ = 0;  // newest echo

  MessageCounts sent_;
  MessageCounts received_;
};

}  // namespace cas::sim

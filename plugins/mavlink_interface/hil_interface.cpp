// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/hil_interface.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "plugins/common/plugin_messages.hpp"
#include "plugins/mavlink_interface/hil_conversion.hpp"
#include "plugins/mavlink_interface/truth_viewer.hpp"

namespace cas::sim {

namespace mv = mavlink::common;
using Json = nlohmann::ordered_json;

namespace {

constexpr std::size_t kMostWaiting = 32;  ///< messages of plugins in one step
constexpr std::size_t kMostAnswers = 16;  ///< commands in one step

/// As a whole number in [0, kMostToken]; 0 for any other value.
std::int32_t token_of(float number) {
  const bool is_one = number >= 0 && number <= static_cast<float>(mav::services::kMostToken);
  return is_one ? static_cast<std::int32_t>(number) : 0;
}

}  // namespace

void MessageCounts::add(std::uint32_t id) {
  for (auto& [known, count] : counts_) {
    if (known == id) {
      ++count;
      return;
    }
  }
  counts_.emplace_back(id, 1);
}

std::uint64_t MessageCounts::of(std::uint32_t id) const {
  const auto found = std::find_if(counts_.begin(), counts_.end(),
                                  [id](const auto& entry) { return entry.first == id; });
  return found == counts_.end() ? 0 : found->second;
}

Json MessageCounts::json() const {
  Json counts = Json::object();
  for (const auto& [id, count] : counts_) {
    const mav::MessageInfo* info = mav::public_table().find(id);
    counts[info ? std::string(info->name) : std::to_string(id)] = count;
  }
  return counts;
}

HilInterface::HilInterface(const HilInterfaceParams& params, HilPort& port,
                           base::PacketLedger* ledger)
    : params_(params),
      port_(port),
      ledger_(ledger),
      on_bytes_([this](std::span<const std::uint8_t> bytes, base::RunTime at) {
        look_for_new_peer();  // whose first bytes come with its connection
        parser_.feed(bytes, [&](const mav::PacketView& packet) { on_packet(packet, at); });
      }),
      heartbeat_(params.heartbeat_hz),
      peers_(port.peers()),
      truth_due_(params.truth_hz),
      parser_(mv::table()),
      in_step_(!params.joins_by_answering),
      control_due_(params.control_rate_hz) {
  waiting_.reserve(kMostWaiting);
}

void HilInterface::flush(base::SimTime now) {
  look_for_new_peer();
  send_heartbeat(now);
  for (const mv::CommandAck& answer : answers_) send(answer);
  answers_.clear();
  if (params_.servos) forget_sensors();
  // Slow sensors first, so that the answer to HIL_SENSOR knows them.
  send_messages();
  if (battery_) send(to_battery_status(*battery_));
  battery_.reset();
  send_escs();
  for (std::size_t id = 0; id < range_.size(); ++id) {
    if (!range_[id]) continue;
    mv::DistanceSensor packet = to_distance_sensor(*range_[id]);
    packet.id = static_cast<std::uint8_t>(id);
    send(packet);
    range_[id].reset();
  }
  send_gps();
  if (truth_) send(*truth_);
  truth_.reset();
  if (const auto time = clock()) send_sensors(*time);
}

/// A controller that connects, or comes back, knows nothing yet and is greeted; one that has gone
/// is not waited for.
void HilInterface::look_for_new_peer() {
  const bool is_new = peers_ != port_.peers();
  peers_ = port_.peers();
  if (is_new) {
    parser_.reset();
    announced_ = false;
    stamps_.clear();
    truth_due_ = base::RateGate();
  }
  if (params_.joins_by_answering && (is_new || !port_.connected())) in_step_ = false;
}

/// From now on the controller answers each HIL_SENSOR; those before are not asked for.
void HilInterface::join() {
  in_step_ = true;
  due_usec_ = answered_usec_ = 0;
}

template <class Message>
bool HilInterface::send(const Message& message) {
  return send_packet(Message::kId, mav::encode(message, params_.self, sequence_++, packet_));
}

bool HilInterface::send_packet(std::uint32_t id, std::size_t size) {
  if (!port_.send(std::span(packet_).first(size))) return false;
  sent_.add(id);
  on_its_way_ = true;
  sensor_sent_last_ = id == mv::HilSensor::kId;
  return true;
}

bool HilInterface::on_message(const mav::MessageInfo& info, const MavlinkMessage& message) {
  if (waiting_.size() == kMostWaiting) return false;
  waiting_.push_back({&info, message});
  return true;
}

void HilInterface::send_terrain(base::SimTime now, const TerrainSource::Elevation& elevation_m) {
  if (const auto grid = terrain_.next(now, elevation_m)) send(*grid);
}

void HilInterface::send_messages() {
  for (const auto& [info, message] : waiting_) {
    send_packet(info->id, encode_message(*info, message, params_.self, sequence_++, packet_));
  }
  waiting_.clear();
}

void HilInterface::send_heartbeat(base::SimTime now) {
  const bool due = heartbeat_.due(now);
  if (announced_ && !due) return;
  announced_ = send(simulator_heartbeat());
}

/// The controller has them from elsewhere.
void HilInterface::forget_sensors() {
  for (SensorSet& set : sets_) {
    set.imu.reset();
    set.magnetometer.reset();
    set.barometer.reset();
  }
  gps_.fill({});
  airspeed_.reset();
}

void HilInterface::send_escs() {
  if (!esc_) return;
  const bool info = esc_info_.due(esc_->time);
  esc_->time += params_.wire_epoch;
  ++escs_sent_;
  for (int first = 0; first < static_cast<int>(esc_->omega_rad_s.size());
       first += kEscsInAMessage) {
    send(to_esc_status(*esc_, first));
    if (info) send(to_esc_info(*esc_, first, escs_sent_));
  }
  esc_.reset();
}

void HilInterface::send_gps() {
  for (std::size_t id = 0; id < gps_.size(); ++id) {
    std::optional<GpsSample>& fix = gps_[id];
    if (!fix) continue;
    fix->time += params_.wire_epoch;
    mv::HilGps packet = to_hil_gps(*fix);
    packet.id = static_cast<std::uint8_t>(id);
    fix.reset();
    const base::RunTime at = port_.now();
    // The ledger tells packets apart by their stamps, which receivers have in common.
    if (send(packet) && ledger_ && id == 0) ledger_->sent(mv::HilGps::kId, packet.time_usec, at);
  }
}

std::optional<base::SimTime> HilInterface::clock() const {
  for (const SensorSet& set : sets_) {
    if (set.imu) return set.imu->time;
  }
  return std::nullopt;
}

void HilInterface::send_sensors(base::SimTime clock) {
  const std::uint64_t time_usec = base::to_time_usec(clock + params_.wire_epoch);
  if (!params_.joins_by_answering) send_further_sensors(time_usec);
  send_clock(time_usec);
  if (params_.joins_by_answering) send_further_sensors(time_usec);
}

void HilInterface::send_further_sensors(std::uint64_t time_usec) {
  for (std::size_t id = 1; id < sets_.size(); ++id) {
    SensorSet& set = sets_[id];
    if (!set.is_new()) continue;
    fill_set(set);
    set.packet.time_usec = time_usec;
    set.packet.id = static_cast<std::uint8_t>(id);
    send(set.packet);
  }
}

/// Takes the new values of a set into its packet. Only they are flagged; the others repeat the last
/// value.
void HilInterface::fill_set(SensorSet& set) {
  set.packet.fields_updated = {};
  if (set.imu) fill(set.packet, *set.imu);
  if (set.magnetometer) fill(set.packet, *set.magnetometer);
  if (set.barometer) fill(set.packet, *set.barometer);
  set.imu.reset();
  set.magnetometer.reset();
  set.barometer.reset();
}

void HilInterface::send_clock(std::uint64_t time_usec) {
  mv::HilSensor& sensor = sets_[0].packet;
  watch_first_imu(sets_[0].imu.has_value(), time_usec);
  fill_set(sets_[0]);
  sensor.time_usec = time_usec;
  if (airspeed_) fill(sensor, *airspeed_);
  airspeed_.reset();
  const base::RunTime at = port_.now();
  const bool sent = send(sensor);
  if (sent && ledger_) ledger_->sent(mv::HilSensor::kId, time_usec, at);

  sent_usec_ = time_usec;
  if (sent) stamps_.add(sent_usec_);
  const bool is_due =
      params_.joins_by_answering ? sent : control_due_.due(base::from_time_usec(sent_usec_));
  if (is_due) due_usec_ = sent_usec_;
}

/// PX4 answers by the IMU that it flies by. When the first one falls silent, it answers now and
/// then until it has chosen another: it is not waited for, and the simulation goes by the clock
/// meanwhile.
void HilInterface::watch_first_imu(bool speaks, std::uint64_t time_usec) {
  const bool falls_silent = !speaks && !first_imu_silent_;
  first_imu_silent_ = !speaks;
  if (falls_silent) leave_step(time_usec);
}

void HilInterface::leave_step(std::uint64_t time_usec) {
  constexpr std::uint64_t kChoosing_usec = 2'000'000;
  if (!params_.joins_by_answering) return;
  in_step_ = false;
  joins_from_usec_ = time_usec + kChoosing_usec;
}

void HilInterface::give_up() {
  due_usec_ = answered_usec_;
  if (first_imu_silent_) leave_step(sent_usec_);
}

void HilInterface::receive() {
  port_.poll(on_bytes_);
  look_for_new_peer();
}

void HilInterface::on_packet(const mav::PacketView& packet, base::RunTime at) {
  received_.add(packet.message_id);
  sequences_.update(packet.source, packet.sequence);
  if (const auto controls = mav::decode<mv::HilControls>(packet)) {
    on_controls(*controls, to_motor_command(*controls, params_.scales), at);
  } else if (const auto outputs = mav::decode<mv::HilActuatorControls>(packet)) {
    on_controls(*outputs, to_motor_command(*outputs), at);
  } else if (const auto pulses = mav::decode<mv::ServoOutputRaw>(packet)) {
    constexpr std::uint8_t kMainOutputs = 0;
    if (!params_.servos || pulses->port != kMainOutputs) return;
    on_controls(*pulses, params_.servos->to_motor_command(*pulses), at);
  } else if (const auto request = mav::decode<mv::TerrainRequest>(packet)) {
    terrain_.take(*request);
  } else {
    on_command(packet);
  }
}

void HilInterface::on_command(const mav::PacketView& packet) {
  const auto command = mav::decode<mv::CommandLong>(packet);
  if (!command) return;
  if (command->command == mv::MavCmd::kSetMessageInterval) on_interval(*command);
  if (command->command == mv::MavCmd::kInjectFailure) on_failure_command(*command, packet);
}

/// PX4 asks for HIL_STATE_QUATERNION once, when it has connected, and waits for no COMMAND_ACK.
void HilInterface::on_interval(const mv::CommandLong& command) {
  constexpr double kUsualHz = 50;  // of an interval of 0: the sender's own choice
  if (!params_.joins_by_answering || std::isnan(command.param2)) return;
  if (command.param1 != static_cast<float>(mv::HilStateQuaternion::kId)) return;
  const double interval_us = command.param2;
  const double asked_hz = interval_us > 0 ? 1e6 / interval_us : interval_us < 0 ? 0 : kUsualHz;
  truth_due_ = base::RateGate(std::min(asked_hz, kMostTruthHz));
}

/// MAV_CMD_INJECT_FAILURE. Its parameter 7 comes back as result_param2, so that the asker can tell
/// a late answer from the next one.
void HilInterface::on_failure_command(const mv::CommandLong& command,
                                      const mav::PacketView& packet) {
  if (mav::Source{command.target_system, command.target_component} != params_.self) return;
  if (answers_.size() == kMostAnswers) return;  // asked again, they are answered
  mv::CommandAck answer;
  answer.command = command.command;
  const auto failure = mav::services::failure_command(packet);
  answer.result = mv::MavResult::kUnsupported;
  if (failure && failure->order && on_failure_) {
    const auto [result, why] = on_failure_(*failure->order);
    answer.result = result;
    answer.progress = static_cast<std::uint8_t>(why);
  }
  answer.result_param2 = token_of(command.param7);
  answer.target_system = packet.source.system;
  answer.target_component = packet.source.component;
  answers_.push_back(answer);
}

template <class Controls>
void HilInterface::on_controls(const Controls& controls, const MotorCommand& command,
                               base::RunTime at) {
  if (ledger_) ledger_->received(Controls::kId, controls.time_usec, at);
  if (command_) ++overwritten_commands_;
  command_ = command;
  command_->sensor_time -= params_.wire_epoch;
  // An echo of a stamp that was never sent comes from another clock, or from before reset().
  const bool may_join = !first_imu_silent_ || sent_usec_ >= joins_from_usec_;
  if (!in_step_ && may_join && stamps_.contains(controls.time_usec)) join();
  if (controls.time_usec <= sent_usec_) {
    answered_usec_ = std::max<std::uint64_t>(answered_usec_, controls.time_usec);
    if (sensor_sent_last_ && answered_usec_ == sent_usec_) on_its_way_ = false;
  }
}

std::optional<MotorCommand> HilInterface::take_command(base::SimTime now) {
  if (command_) {
    last_command_ = now;
    return std::exchange(command_, std::nullopt);
  }
  if (!last_command_ || now - *last_command_ < params_.actuator_timeout) return std::nullopt;
  last_command_.reset();
  ++actuator_timeouts_;
  return MotorCommand{};  // disarmed, zeros
}

Json HilInterface::figures() const {
  const auto& parser = parser_.stats();
  Json port = Json::object();
  port_.add_figures(port);
  return {{"endpoint", port_.endpoint()},
          {"sent", sent_.json()},
          {"received", received_.json()},
          {"crc_errors", parser.crc_errors},
          {"sequence_gaps", sequences_.lost()},
          {"unknown_ids", parser.unknown_ids},
          {"skipped_bytes", parser.skipped_bytes},
          {"overwritten_commands", overwritten_commands_},
          {"actuator_timeouts", actuator_timeouts_},
          {"in_step", in_step_},
          {"truth_hz", truth_hz()},
          {"port", std::move(port)}};
}

}  // namespace cas::sim

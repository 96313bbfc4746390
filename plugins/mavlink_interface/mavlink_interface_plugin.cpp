// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/config/config_whole.hpp"
#include "base/config/sensor_names.hpp"
#include "base/error.hpp"
#include "base/measure/ledger.hpp"
#include "base/os/log.hpp"
#include "base/os/result_file.hpp"
#include "libsim/api/fault_order.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/companion.hpp"
#include "plugins/common/plugin_messages.hpp"
#include "plugins/common/result_path.hpp"
#include "plugins/mavlink_interface/bus_port.hpp"
#include "plugins/mavlink_interface/failure_map.hpp"
#include "plugins/mavlink_interface/hil_conversion.hpp"
#include "plugins/mavlink_interface/hil_interface.hpp"
#include "plugins/mavlink_interface/tcp_server_port.hpp"
#include "plugins/mavlink_interface/truth_viewer.hpp"
#include "plugins/mavlink_interface/udp_port.hpp"

namespace cas::sim {
namespace {

constexpr const char* kTcpServer = "tcp_server";  // PX4's simulator API
constexpr int kSimulatorApiPort = 4560;           // of PX4's instance 0
constexpr int kMostInstances = 250;

std::uint8_t parse_id(const base::ConfigNode& node, const char* key, std::uint8_t fallback) {
  return base::get_whole_in<std::uint8_t>(node, key, fallback, 1, 255);
}

HilInterfaceParams parse_params(const base::ConfigNode& node, const base::Vehicle& vehicle) {
  constexpr double kMostHertz = 10000;
  HilInterfaceParams params;
  params.self = {parse_id(node, "system_id", vehicle.system_id),
                 parse_id(node, "component_id", kSimulatorComponent)};
  params.scales = vehicle.scales;
  params.heartbeat_hz = node.get_in("heartbeat_hz", 1, 0, kMostHertz);
  params.control_rate_hz = node.get_in("control_rate_hz", 400, 0, kMostHertz);
  params.actuator_timeout = base::from_seconds(node.get_in("actuator_timeout_s", 0.5, 0.01, 60));
  params.joins_by_answering = node.require<std::string>("transport") == kTcpServer;
  if (const auto servos = node.find("servo_outputs")) params.servos.emplace(*servos, vehicle);
  constexpr double kYear2100 = 4102444800;  // s since 1970
  params.wire_epoch =
      std::chrono::seconds(std::llround(node.get_in("start_unix_s", 0, 0, kYear2100)));
  return params;
}

std::unique_ptr<HilPort> open_tcp_server(const base::ConfigNode& node) {
  const int instance = base::get_whole_in<int>(node, "instance", 0, 0, kMostInstances);
  const auto local = node.find("local");
  if (local && node.has("instance")) local->fail("stands for the port; so does instance");
  const InetAddress address =
      local ? InetAddress::parse(*local)
            : InetAddress::loopback(static_cast<std::uint16_t>(kSimulatorApiPort + instance));
  try {
    return std::make_unique<TcpServerPort>(address);
  } catch (const std::system_error& error) {
    (local ? *local : node).fail("TCP " + address.text() + ": " + error.code().message());
  }
}

std::unique_ptr<HilPort> open_port(PluginContext& context, const base::ConfigNode& node) {
  const base::ConfigNode transport = node.at("transport");
  const auto word = transport.as<std::string>();
  if (word == "udp") return std::make_unique<UdpPort>(node.at("local"), node.find("remote"));
  if (word == "bus") return std::make_unique<BusPort>(context);
  if (word == kTcpServer) return open_tcp_server(node);
  transport.fail("must be udp, tcp_server or bus");
}

/// Sends the sensors of one vehicle as MAVLink and takes its actuator commands ([HILS] Fig. 6).
class MavlinkInterfacePlugin final : public Plugin, public LockstepPeer {
 public:
  void configure(PluginContext& context, const base::ConfigNode& node) override {
    params_ = parse_params(node, context.vehicle());
    port_ = open_port(context, node);
    if (const auto viewer = node.find("viewer")) viewer_.emplace(*viewer, params_.self);
    if (const auto remote = node.find("companion")) companion_.emplace(*remote, params_.self);
    vehicle_ = context.vehicle_id();
    output_ = context.output_dir();
    if (const auto ledger = node.find("ledger")) ledger_file_ = result_path(*ledger);
    begin();
    subscribe(context);
    listen_to_plugins(context);
    command_ = context.bus().advertise<MotorCommand>(context.topic("motor_command"));
    rotors_ = context.vehicle().rotor_count();
    faults_ = context.bus().advertise<FaultOrder>(context.topic(std::string(kStationFaultOrders)));
    context.set_lockstep_peer(*this);
  }

  void pre_step(const StepInfo& step, World&) override {
    now_ = step.time;
    port_->set_sim_time(step.time);
    if (!std::exchange(has_all_, false)) interface_->receive();
    if (const auto command = interface_->take_command(step.time)) command_.publish(*command);
  }

  void post_step(const StepInfo& step, const World& world) override {
    now_ = step.time;
    port_->set_sim_time(step.time);
    show_truth(step.time, world);
    if (elevation_m_) interface_->send_terrain(step.time, elevation_m_);
    interface_->flush(step.time);
  }

  bool wait_for_controls(base::SimTime, base::Duration timeout) override {
    if (interface_->answered()) {
      has_all_ = has_all_ || interface_->settled();  // nothing is on its way
      return true;
    }
    const base::RunTime deadline = base::steady_now() + timeout;
    interface_->receive();
    has_all_ = true;
    while (interface_->in_step() && !interface_->answered()) {
      const base::Duration left = deadline - base::steady_now();
      if (left <= base::Duration::zero() || !port_->wait(left)) return false;
      interface_->receive();
    }
    return true;
  }

  void give_up() override { interface_->give_up(); }
  bool in_step() const override { return interface_->in_step(); }

  void reset() override {
    // A controller that stays connected has seen the time that was: for it the clock goes on.
    if (params_.joins_by_answering) {
      params_.wire_epoch = std::max(params_.wire_epoch, interface_->wire_end());
    }
    params_.truth_hz = interface_->truth_hz();
    if (viewer_) viewer_->reset();
    messages_.reset();
    too_many_ = 0;
    now_ = {};
    has_all_ = false;
    begin();
  }
  bool settled() const override { return interface_->settled(); }

  void finish() override {
    if (!ledger_) return;
    interface_->receive();  // packets after the last step belong to the ledger
    base::write_result({output_, ledger_file_}, ledger_->csv());
  }

  std::string stats_json() const override {
    nlohmann::ordered_json figures = interface_->figures();
    if (!plugins_.empty()) {
      figures["plugins"] = messages_.json();
      figures["too_many_in_a_step"] = too_many_;
    }
    if (viewer_) figures["viewer"] = viewer_->figures();
    if (companion_) figures["companion"] = companion_->figures();
    return figures.dump();
  }

 private:
  /// Computes nothing without a request.
  void show_truth(base::SimTime now, const World& world) {
    const bool to_controller = interface_->truth_due(now);
    const bool to_viewer = viewer_ && viewer_->due(now);
    if (!to_controller && !to_viewer) return;
    const auto truth = to_hil_state(now + params_.wire_epoch, world.state(vehicle_),
                                    world.environment(vehicle_), world.projection());
    if (to_controller) interface_->on_truth(truth);
    if (to_viewer) viewer_->show(truth);
  }

  void begin() {
    if (!ledger_file_.empty()) ledger_.emplace();
    interface_ = std::make_unique<HilInterface>(params_, *port_, ledger_ ? &*ledger_ : nullptr);
    interface_->on_failure(
        [this](const mav::services::FailureOrder& failure) { return inject(failure); });
  }

  /// Hands a ground station's failure to plugin `fault`.
  HilInterface::FailureAnswer inject(const mav::services::FailureOrder& failure) {
    using mav::services::FailureOrder;
    using mav::services::FailureRefusal;
    using mav::services::FailureType;
    using mavlink::common::MavResult;
    const std::string words = "MAV_CMD_INJECT_FAILURE '" + to_words(failure) + "'";
    const VehicleParts parts{.sensors = interface_->sensors(), .rotors = rotors_};
    const auto orders = fault_orders(failure, parts);
    if (!orders) {
      base::log::warn(words + ": this vehicle has no such physical failure");
      return {MavResult::kUnsupported, why_no_orders(failure, parts)};
    }
    if (!faults_.has_subscribers()) {
      base::log::warn(words + ": the vehicle has no plugin fault with by_hand");
      return {MavResult::kUnsupported, FailureRefusal::kByHand};
    }
    try {
      publish(*orders);
    } catch (const base::ConfigError& error) {  // more than one run takes
      const FailureOrder end{failure.unit, FailureType::kOk, failure.instance};
      publish(*fault_orders(end, parts));  // of several orders some were perhaps taken
      base::log::warn(words + ": " + error.what());
      return {MavResult::kFailed, FailureRefusal::kFull};
    }
    base::log::info(words + ": ordered");
    return {MavResult::kAccepted};
  }

  /// @throws base::ConfigError when plugin `fault` takes no more; an end it always takes
  void publish(const std::vector<std::string>& scripts) {
    for (const std::string& script : scripts) {
      FaultOrder order;
      CAS_CHECK(script.size() < order.script.size());
      std::ranges::copy(script, order.script.begin());
      faults_.publish(order);
    }
  }

  /// Listens to all sensors of a kind; those that the vehicle does not have stay silent.
  template <class Sample>
  void listen(PluginContext& context, const char* topic,
              void (HilInterface::*take)(const Sample&, std::size_t)) {
    for (int number = 1; number <= base::most_sensors(topic); ++number) {
      const std::size_t at = static_cast<std::size_t>(number) - 1;
      sensors_.push_back(context.bus().subscribe<Sample>(
          context.topic(base::sensor_name(topic, number)),
          [this, take, at](const Sample& sample) { ((*interface_).*take)(sample, at); },
          Need::kOptional));
    }
  }

  void subscribe(PluginContext& context) {
    listen<ImuSample>(context, "imu", &HilInterface::on_imu);
    listen<GpsSample>(context, "gps", &HilInterface::on_gps);
    listen<MagnetometerSample>(context, "magnetometer", &HilInterface::on_magnetometer);
    listen<BarometerSample>(context, "barometer", &HilInterface::on_barometer);
    listen<AirspeedSample>(context, "airspeed", &HilInterface::on_airspeed);
    listen<RangeSample>(context, "rangefinder", &HilInterface::on_range);
    listen<OdometrySample>(context, "odometry", &HilInterface::on_odometry);
    battery_ = context.bus().subscribe<BatterySample>(
        context.topic("battery"),
        [this](const BatterySample& sample) { interface_->on_battery(sample); }, Need::kOptional);
    esc_ = context.bus().subscribe<EscSample>(
        context.topic("esc"), [this](const EscSample& sample) { interface_->on_esc(sample); },
        Need::kOptional);
    terrain_ = context.bus().subscribe<TerrainSource>(
        "terrain", [this](const TerrainSource& source) { elevation_m_ = source.elevation_m; },
        Need::kOptional);
  }

  void listen_to_plugins(PluginContext& context) {
    const std::vector<MavlinkSender> senders = context.mavlink_senders();
    messages_ = PluginMessages(senders);
    plugins_ = hear_plugins(
        context.bus(), senders,
        [this](std::size_t sender, const MavlinkMessage& message) { on_message(sender, message); });
  }

  void on_message(std::size_t sender, const MavlinkMessage& message) {
    std::string refusal;
    const mav::MessageInfo* info = messages_.admit(sender, message, now_, refusal);
    if (!refusal.empty()) base::log::warn(refusal);
    if (info == nullptr) return;
    if (companion_) return companion_->send(*info, message);
    if (!interface_->on_message(*info, message)) ++too_many_;
  }

  HilInterfaceParams params_;
  std::unique_ptr<HilPort> port_;
  std::filesystem::path output_;
  std::filesystem::path ledger_file_;  // relative to output_
  std::optional<base::PacketLedger> ledger_;
  std::unique_ptr<HilInterface> interface_;
  VehicleId vehicle_{};
  std::optional<TruthViewer> viewer_;
  std::vector<Subscription> sensors_;
  std::optional<Companion> companion_;  ///< takes the messages of plugins
  Subscription terrain_;
  TerrainSource::Elevation elevation_m_;  // empty: the world has no terrain
  Subscription battery_;
  Subscription esc_;
  Publisher<MotorCommand> command_;
  Publisher<FaultOrder> faults_;
  int rotors_ = 0;
  base::SimTime now_{};
  bool has_all_ = false;  ///< lockstep: the wait has read all input of this step
  PluginMessages messages_;
  std::vector<Subscription> plugins_;  ///< to messages that plugins send themselves
  std::uint64_t too_many_ = 0;         ///< messages of plugins that one step had no room for
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::MavlinkInterfacePlugin, "mavlink_interface")

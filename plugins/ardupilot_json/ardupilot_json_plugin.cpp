// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "base/config/sensor_names.hpp"
#include "base/os/log.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/ardupilot_json/json_link.hpp"
#include "plugins/ardupilot_json/json_messages.hpp"
#include "plugins/ardupilot_json/servo_clock.hpp"
#include "plugins/common/companion.hpp"
#include "plugins/common/plugin_messages.hpp"

namespace cas::sim {
namespace {

constexpr std::uint16_t kPort = 9002;  // of ArduPilot's model "json:127.0.0.1", instance 0
constexpr int kMostPackets = 1024;     // at once: a sender that never pauses is not waited for

std::unique_ptr<JsonLink> open_link(const base::ConfigNode& node) {
  const auto local = node.find("local");
  const InetAddress address = local ? InetAddress::parse(*local) : InetAddress::loopback(kPort);
  try {
    return std::make_unique<JsonLink>(address);
  } catch (const std::system_error& error) {
    (local ? *local : node).fail("UDP " + address.text() + ": " + error.code().message());
  }
}

/// Flies a vehicle with ArduPilot's SITL: pulse widths in, the true motion out, one answer for each
/// of the firmware's packets. ArduPilot makes its own sensors and their noise from the motion.
///
///   wait_for_controls <-- servo packet        pre_step: motor_command
///   post_step: its period has ended --> one line of text
///
/// The interface has no MAVLink: a companion's link, if it has one, takes messages of other plugins
/// and requests for terrain.
class ArdupilotJsonPlugin final : public Plugin, public LockstepPeer {
 public:
  void configure(PluginContext& context, const base::ConfigNode& node) override {
    step_ = context.step();
    vehicle_ = context.vehicle_id();
    airframe_ = context.vehicle();
    refuse_several(context, node);
    link_ = open_link(node);
    clock_ = ServoClock(step_);
    range_ = context.bus().subscribe<RangeSample>(
        context.topic("rangefinder"),
        [this](const RangeSample& sample) {
          newest_range_m_ = sample.valid ? std::optional(sample.distance_m) : std::nullopt;
        },
        Need::kOptional);
    pitot_ = context.bus().subscribe<AirspeedSample>(
        context.topic("airspeed"),
        [this](const AirspeedSample& sample) {
          differential_pressure_pa_ = sample.differential_pressure_pa;
        },
        Need::kOptional);
    if (const auto remote = node.find("companion")) be_companion(context, *remote);
    terrain_ = context.bus().subscribe<TerrainSource>(
        "terrain", [this](const TerrainSource& source) { elevation_m_ = source.elevation_m; },
        Need::kOptional);
    command_ = context.bus().advertise<MotorCommand>(context.topic("motor_command"));
    context.set_lockstep_peer(*this);
  }

  bool wait_for_controls(base::SimTime time, base::Duration timeout) override {
    now_ = time;
    const base::RunTime deadline = base::steady_now() + timeout;
    receive();
    while (!clock_.pending()) {
      const base::Duration left = deadline - base::steady_now();
      if (left <= base::Duration::zero() || !link_->wait(left)) return false;
      receive();
    }
    return true;
  }
  /// A firmware that has not spoken yet is not waited for.
  bool in_step() const override { return heard_; }

  void pre_step(const StepInfo& step, World&) override {
    now_ = step.time;
    receive();
    if (packet_) command_.publish(to_motor_command(*packet_, airframe_));
    packet_.reset();
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (companion_ && elevation_m_) companion_->serve_terrain(step.time, elevation_m_);
    receive();  // a repeat of the pending packet gets one answer, not two
    if (!clock_.due(step.time)) return;
    const Environment& air = world.environment(vehicle_);
    JsonState state = to_json_state(step.time + epoch_, world.state(vehicle_), air);
    state.range_m = newest_range_m_;
    if (differential_pressure_pa_) {
      state.airspeed_m_s = to_airspeed_m_s(*differential_pressure_pa_, air.air_density_kg_m3);
    }
    answer_ = to_text(state);
    newest_ = step.time;
    clock_.answered();
    send();
  }

  void reset() override {
    // For a firmware that goes on, time does not turn back.
    epoch_ += newest_.time_since_epoch();
    newest_ = {};
    clock_ = ServoClock(step_);
    heard_ = false;
    packet_.reset();
    messages_.reset();
    if (companion_) companion_->reset();
  }

  std::string stats_json() const override {
    const ServoClock::Counts& counts = clock_.counts();
    nlohmann::ordered_json figures{{"endpoint", link_->endpoint()}, {"peer", link_->peer()},
                                   {"packets", counts.packets},     {"repeated", counts.repeated},
                                   {"skipped", counts.skipped},     {"restarts", counts.restarts},
                                   {"bad_packets", bad_packets_},   {"send_errors", send_errors_}};
    if (companion_) {
      figures["plugins"] = messages_.json();
      figures["companion"] = companion_->figures();
    }
    return figures.dump();
  }

 private:
  /// The interface has no number for a sensor.
  static void refuse_several(PluginContext& context, const base::ConfigNode& node) {
    for (const base::SensorKind& kind : base::kSensorKinds) {
      const std::string name = base::sensor_name(kind.plugin, 2);
      if (!context.bus().is_advertised(context.topic(name))) continue;
      node.fail("carries no " + name + ": ArduPilot's JSON interface has one sensor of a kind");
    }
  }

  void be_companion(PluginContext& context, const base::ConfigNode& remote) {
    companion_.emplace(remote, mav::Source{airframe_.system_id, kSimulatorComponent});
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
    if (info != nullptr) companion_->send(*info, message);
  }

  void receive() {
    for (int i = 0; i < kMostPackets; ++i) {
      const auto bytes = link_->receive();
      if (!bytes) return;
      if (const auto packet = parse_servo_packet(*bytes)) {
        on_packet(*packet);
      } else {
        ++bad_packets_;
      }
    }
  }

  void on_packet(const ServoPacket& packet) {
    const ServoClock::Kind kind = clock_.on_packet(packet, now_);
    if (kind == ServoClock::Kind::kRepeated) return send();
    if (kind == ServoClock::Kind::kPending) return;
    packet_ = packet;
    if (!heard_) base::log::info(link_->endpoint() + ": ArduPilot speaks from " + link_->peer());
    if (kind == ServoClock::Kind::kRestart) {
      base::log::info(link_->endpoint() + ": ArduPilot has started anew, from " + link_->peer());
    }
    heard_ = true;
  }

  void send() {
    if (!link_->send(answer_)) ++send_errors_;
  }

  std::unique_ptr<JsonLink> link_;
  VehicleId vehicle_{};
  base::Vehicle airframe_;
  base::Duration step_{};
  ServoClock clock_{base::Duration(1)};
  bool heard_ = false;
  base::SimTime now_{};
  base::Duration epoch_{};  // total time of earlier runs of this firmware
  base::SimTime newest_{};
  std::optional<ServoPacket> packet_;
  std::string answer_;  // the last, to be repeated
  std::optional<double> newest_range_m_;
  std::optional<double> differential_pressure_pa_;  // newest of a pitot tube
  std::uint64_t bad_packets_ = 0;
  std::uint64_t send_errors_ = 0;
  Publisher<MotorCommand> command_;
  Subscription range_;
  Subscription pitot_;
  std::optional<Companion> companion_;  ///< takes the messages of plugins
  Subscription terrain_;
  TerrainSource::Elevation elevation_m_;  ///< empty: the world has no terrain
  PluginMessages messages_;
  std::vector<Subscription> plugins_;  ///< to messages that plugins send themselves
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::ArdupilotJsonPlugin, "ardupilot_json")

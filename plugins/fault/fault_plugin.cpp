// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/angles.hpp"
#include "base/config/sensor_names.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"
#include "base/os/log.hpp"
#include "libsim/api/fault_order.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/odometry_sample.hpp"
#include "libsim/api/plugin.hpp"
#include "libsim/api/surface_health.hpp"
#include "plugins/common/rounding.hpp"
#include "plugins/fault/fault_spec.hpp"
#include "plugins/fault/sensor_tap.hpp"

namespace cas::sim {
namespace {

constexpr std::size_t kMostByHand = 200;  // faults that are ordered in one run
constexpr std::size_t kMostOfAKind = 3;   // sensors, see base::kSensorKinds

/// Breaks sensors, rotors, battery and balance by script, and starts gusts.
class FaultPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    random_ = base::NormalRandom(seed_);
    by_hand_ = params.get("by_hand", false);
    if (!by_hand_ || params.has("faults")) schedule_ = FaultSchedule(parse_faults(params));
    schedule_.reserve(by_hand_ ? kMostByHand : 0);
    events_.reserve(2 * (schedule_.faults().size() + kMostByHand));
    open_taps(context);
    open_topics(context);
  }

  void pre_step(const StepInfo& step, World& world) override {
    const base::SimTime end = step.time + step.dt;  // when the sensors of this step will speak
    const double power_share = hover_power_ > 0 ? power_ / hover_power_ : 0;
    const double pressure_pa = dynamic_pressure_pa(world);
    for_each_tap([&](auto& tap) {
      tap.set_now(end);
      tap.set_drivers(power_share, pressure_pa, vibration_);
    });
    if (step.index == 0) begin_run(world);
    schedule_.update(step.time, facts(step.time, world),
                     [&](const FaultEvent& event) { on_event(event, world); });
    shift_cg(world);
  }

  void post_step(const StepInfo&, const World&) override {
    for_each_tap([](auto& tap) { tap.release(); });
  }

  void reset() override {
    schedule_.reset();
    for_each_tap([](auto& tap) { tap.reset(); });
    random_ = base::NormalRandom(seed_);
    events_.clear();
    armed_ = false;
    phase_ = {};
    power_ = 0;
    vibration_ = 0;
    std::ranges::fill(turned_rad_, 0.0);
    if (breaks_propulsion_) health_.publish({});
    if (breaks_surfaces_) surface_health_.publish({});
  }

  std::string stats_json() const override {
    using Json = nlohmann::ordered_json;
    Json events = Json::array();
    for (const FaultEvent& event : events_) {
      events.push_back({{"time_s", six_decimals(base::to_seconds(event.time))},
                        {"fault", shown(schedule_.faults()[event.fault].name)},
                        {"event", event.begins ? "begin" : "end"}});
    }
    Json figures{{"events", std::move(events)}};
    if (blows_at_nothing_) figures["warnings"].push_back(kNoWind);
    return figures.dump();
  }

 private:
  static constexpr const char* kNoWind =
      "plugin fault: a fault starts a gust, but the vehicle has no plugin wind";

  /// The taps of one kind of sensor, by number.
  template <class Sample>
  using Taps = std::array<SensorTap<Sample>, kMostOfAKind>;

  template <class Action>
  void for_each_tap(Action&& action) {
    const auto each = [&action](auto& taps) {
      for (auto& tap : taps) action(tap);
    };
    std::apply([&](auto&... taps) { (each(taps), ...); }, taps_);
  }

  static std::string shown(std::string name) {
    std::ranges::replace_if(
        name, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    return name;
  }

  /// Intercepts the topics that a fault is about, and no other; by hand all that there are.
  template <class Sample>
  void open_taps_of(PluginContext& context, SensorTopic topic) {
    const std::string_view word = sensor_word(topic);
    for (int number = 1; number <= base::most_sensors(word); ++number) {
      const std::string name = context.topic(base::sensor_name(word, number));
      const bool by_hand = by_hand_ && (number == 1 || context.bus().is_advertised(name));
      bool wanted = by_hand;
      bool may_delay = by_hand;
      for (const FaultSpec& fault : schedule_.faults()) {
        const auto* sensor = std::get_if<SensorFault>(&fault.kind);
        if (sensor == nullptr || sensor->topic != topic || sensor->number != number) continue;
        wanted = true;
        may_delay |= sensor->effect == SensorEffect::kDelay;
      }
      if (!wanted) continue;
      std::get<Taps<Sample>>(taps_)[static_cast<std::size_t>(number - 1)].open(
          context.bus(), name, SampleAccess(context.projection()), may_delay, random_);
    }
  }

  void open_taps(PluginContext& context) {
    open_taps_of<ImuSample>(context, SensorTopic::kImu);
    open_taps_of<GpsSample>(context, SensorTopic::kGps);
    open_taps_of<MagnetometerSample>(context, SensorTopic::kMagnetometer);
    open_taps_of<BarometerSample>(context, SensorTopic::kBarometer);
    open_taps_of<RangeSample>(context, SensorTopic::kRangefinder);
    open_taps_of<AirspeedSample>(context, SensorTopic::kAirspeed);
    open_taps_of<FlowSample>(context, SensorTopic::kOpticalFlow);
    open_taps_of<OdometrySample>(context, SensorTopic::kOdometry);
    open_taps_of<LandingTargetSample>(context, SensorTopic::kLandingTarget);
  }

  void open_topics(PluginContext& context) {
    airframe_ = context.vehicle();
    for (const base::SensorKind& kind : base::kSensorKinds) {
      for (int number = 2; number <= kind.most; ++number) {
        const std::string name = base::sensor_name(kind.plugin, number);
        if (context.bus().is_advertised(context.topic(name))) further_.push_back(name);
      }
    }
    breaks_propulsion_ = changes_mass_ = blows_ = cuts_line_ = by_hand_;
    breaks_surfaces_ = by_hand_ && context.vehicle().aero.has_value();
    for (const FaultSpec& fault : schedule_.faults()) {
      check_part(fault);
      check_sensor(fault);
      breaks_propulsion_ |= breaks_propulsion(fault.kind);
      breaks_surfaces_ |= std::holds_alternative<SurfaceFault>(fault.kind);
      changes_mass_ |= std::holds_alternative<MassFault>(fault.kind);
      blows_ |= std::holds_alternative<GustCommand>(fault.kind);
      cuts_line_ |= std::holds_alternative<LineCutFault>(fault.kind);
    }
    TopicBus& bus = context.bus();
    if (breaks_propulsion_) {
      health_ = bus.advertise<PropulsionHealth>(context.topic("propulsion_health"));
    }
    if (breaks_surfaces_) {
      surface_health_ = bus.advertise<SurfaceHealth>(context.topic(std::string(kSurfaceHealth)));
    }
    if (blows_) gust_ = bus.advertise<GustCommand>(context.topic("gust"));
    if (cuts_line_) line_cut_ = bus.advertise<LineCut>(context.topic("line_cut"));
    if (by_hand_) {
      const auto take = [this](const FaultOrder& order) { take_order(order); };
      orders_ = bus.subscribe<FaultOrder>(context.topic(std::string(kFaultOrders)), take,
                                          Need::kOptional);
      station_orders_ = bus.subscribe<FaultOrder>(context.topic(std::string(kStationFaultOrders)),
                                                  take, Need::kOptional);
    }
    command_ = bus.subscribe<MotorCommand>(
        context.topic("motor_command"),
        [this](const MotorCommand& command) { armed_ = command.armed; }, Need::kOptional);
    listen_to_rotors(context);
    phase_topic_ = bus.subscribe<FlightPhase>(
        context.topic("flight_phase"), [this](const FlightPhase& phase) { phase_ = phase; },
        Need::kOptional);
  }

  /// Not while the schedule is being updated. @throws base::ConfigError to the caller
  void take_order(const FaultOrder& order) {
    const auto script = base::ConfigNode::parse(order.script.data(), "fault by hand");
    if (const auto end = script.find("end")) return schedule_.end(end->as<std::string>());
    FaultSpec fault = parse_fault(script, schedule_.faults().size() + 1);
    check_part(fault);
    check_sensor(fault);
    if (std::holds_alternative<GustCommand>(fault.kind) && !gust_.has_subscribers()) {
      throw base::ConfigError("no gust can blow: the vehicle has no plugin wind");
    }
    schedule_.add(std::move(fault));
  }

  /// @throws base::ConfigError
  void check_part(const FaultSpec& fault) const {
    const std::string missing = missing_part(fault.kind, airframe_);
    if (!missing.empty()) throw base::ConfigError("fault '" + fault.name + "': " + missing);
  }

  /// A second sensor that is not there could not fail. @throws base::ConfigError
  void check_sensor(const FaultSpec& fault) const {
    const auto* sensor = std::get_if<SensorFault>(&fault.kind);
    if (sensor == nullptr || sensor->number == 1) return;
    const std::string name = base::sensor_name(sensor_word(sensor->topic), sensor->number);
    if (std::ranges::find(further_, name) != further_.end()) return;
    throw base::ConfigError("fault '" + fault.name + "': vehicle '" + airframe_.name + "' has no " +
                            name + " in front of plugin fault");
  }

  /// Power goes with the sum of k_m w^3; in a hover the rotors share the weight equally.
  void listen_to_rotors(PluginContext& context) {
    const base::Vehicle& vehicle = context.vehicle();
    const double share_n =
        vehicle.mass_kg * base::kStandardGravity_m_s2 / std::max(1, vehicle.rotor_count());
    for (const base::Rotor& rotor : vehicle.rotors) {
      torque_coefficients_.push_back(rotor.params.torque_coefficient);
      const double omega = std::sqrt(share_n / rotor.params.thrust_coefficient);
      hover_power_ += torque_coefficients_.back() * omega * omega * omega;
      hover_rad_s_.push_back(omega);
    }
    turned_rad_.resize(hover_rad_s_.size());
    const double step_s = base::to_seconds(context.step());
    rotor_speeds_ = context.bus().subscribe<RotorSpeeds>(
        context.topic("rotor_speeds"),
        [this, step_s](const RotorSpeeds& speeds) {
          power_ = vibration_ = 0;
          for (std::size_t i = 0; i < torque_coefficients_.size(); ++i) {
            const double omega = speeds.omega_rad_s[static_cast<Eigen::Index>(i)];
            power_ += torque_coefficients_[i] * omega * omega * omega;
            const double share = omega / hover_rad_s_[i];
            turned_rad_[i] = std::remainder(turned_rad_[i] + omega * step_s, 2 * M_PI);
            vibration_ += share * share * std::sin(turned_rad_[i]);
          }
        },
        Need::kOptional);
  }

  double dynamic_pressure_pa(const World& world) const {
    const Environment& air = world.environment(vehicle_);
    return 0.5 * air.air_density_kg_m3 * (world.state(vehicle_).v_WB - air.wind_W).squaredNorm();
  }

  void begin_run(World& world) {
    if (changes_mass_) world.scale_mass(vehicle_, 1.0);
    blows_at_nothing_ = blows_ && !by_hand_ && !gust_.has_subscribers();
    if (blows_at_nothing_) base::log::warn(kNoWind);
  }

  Facts facts(base::SimTime now, const World& world) const {
    const BodyState& state = world.state(vehicle_);
    const Eigen::Vector3d rpy =
        base::euler_rpy(base::q_ND_from_q_WB(state.q_WB)) * base::kDegPerRad;
    Facts facts;
    facts[Fact::kTime] = base::to_seconds(now);
    facts[Fact::kAltitude] = state.p_WB.z();
    facts[Fact::kHeight] = world.environment(vehicle_).height_above_ground_m;
    facts[Fact::kNorth] = state.p_WB.y();
    facts[Fact::kEast] = state.p_WB.x();
    facts[Fact::kSpeed] = state.v_WB.norm();
    facts[Fact::kClimb] = state.v_WB.z();
    facts[Fact::kRoll] = rpy[0];
    facts[Fact::kPitch] = rpy[1];
    facts[Fact::kYaw] = rpy[2];
    facts[Fact::kArmed] = armed_ ? 1 : 0;
    facts.phase = phase_.name.data();
    return facts;
  }

  void on_event(const FaultEvent& event, World& world) {
    const FaultSpec& fault = schedule_.faults()[event.fault];
    events_.push_back(event);
    base::log::info(fmt::format("fault '{}' {} at {:f} s", fault.name,
                                event.begins ? "begins" : "ends", base::to_seconds(event.time)));
    if (const auto* sensor = std::get_if<SensorFault>(&fault.kind)) {
      switch_sensor(*sensor, event.begins);
    } else if (const auto* gust = std::get_if<GustCommand>(&fault.kind)) {
      if (event.begins) gust_.publish(*gust);
    } else if (std::holds_alternative<LineCutFault>(fault.kind)) {
      line_cut_.publish({.cut = is_line_cut()});
    } else if (std::holds_alternative<MassFault>(fault.kind)) {
      world.scale_mass(vehicle_, mass_factor());
    } else if (std::holds_alternative<SurfaceFault>(fault.kind)) {
      surface_health_.publish(surface_health());
    } else if (breaks_propulsion_) {
      health_.publish(propulsion_health());
    }
  }

  void switch_sensor(const SensorFault& fault, bool begins) {
    const auto apply = [&](auto& taps) {
      auto& tap = taps[static_cast<std::size_t>(fault.number - 1)];
      begins ? tap.begin(fault) : tap.end(fault);
    };
    switch (fault.topic) {
      case SensorTopic::kImu:
        return apply(std::get<Taps<ImuSample>>(taps_));
      case SensorTopic::kGps:
        return apply(std::get<Taps<GpsSample>>(taps_));
      case SensorTopic::kMagnetometer:
        return apply(std::get<Taps<MagnetometerSample>>(taps_));
      case SensorTopic::kBarometer:
        return apply(std::get<Taps<BarometerSample>>(taps_));
      case SensorTopic::kRangefinder:
        return apply(std::get<Taps<RangeSample>>(taps_));
      case SensorTopic::kAirspeed:
        return apply(std::get<Taps<AirspeedSample>>(taps_));
      case SensorTopic::kOpticalFlow:
        return apply(std::get<Taps<FlowSample>>(taps_));
      case SensorTopic::kOdometry:
        return apply(std::get<Taps<OdometrySample>>(taps_));
      case SensorTopic::kLandingTarget:
        return apply(std::get<Taps<LandingTargetSample>>(taps_));
    }
  }

  /// Calls action(kind) for each active fault of that kind.
  template <class Kind, class Action>
  void for_active(Action&& action) const {
    for (std::size_t i = 0; i < schedule_.faults().size(); ++i) {
      const auto* kind = std::get_if<Kind>(&schedule_.faults()[i].kind);
      if (kind != nullptr && schedule_.is_active(i)) action(*kind);
    }
  }

  /// Whether any active fault cuts the line.
  bool is_line_cut() const {
    bool cut = false;
    for_active<LineCutFault>([&](const LineCutFault&) { cut = true; });
    return cut;
  }

  double mass_factor() const {
    double factor = 1;
    for_active<MassFault>([&](const MassFault& fault) { factor *= fault.factor; });
    return factor;
  }

  PropulsionHealth propulsion_health() const {
    PropulsionHealth health;
    for_active<RotorFault>([&](const RotorFault& fault) {
      health.speed_share[fault.rotor] *= fault.speed_share;
      health.thrust_share[fault.rotor] *= fault.thrust_share;
      health.stuck[static_cast<std::size_t>(fault.rotor)] |= fault.stuck;
      health.without_current[static_cast<std::size_t>(fault.rotor)] |= fault.desync;
    });
    for_active<SwapFault>([&](const SwapFault& fault) {
      std::swap(health.wired_as[static_cast<std::size_t>(fault.first)],
                health.wired_as[static_cast<std::size_t>(fault.second)]);
    });
    for_active<VoltageFault>(
        [&](const VoltageFault& fault) { health.voltage_share *= fault.share; });
    return health;
  }

  /// State of the servos; where several faults hold one surface in place, the last in the list
  /// counts.
  SurfaceHealth surface_health() const {
    SurfaceHealth health;
    for_active<SurfaceFault>([&](const SurfaceFault& fault) {
      ServoHealth& servo = health.servos[*fault.index_in(airframe_)];
      switch (fault.defect) {
        case SurfaceDefect::kStuck:
          servo.rate_share = 0;
          break;
        case SurfaceDefect::kHeld:
          servo.held_rad = fault.angle_rad;
          break;
        case SurfaceDefect::kReversed:
          servo.reversed = !servo.reversed;
          break;
        case SurfaceDefect::kDead:
          servo.held_rad = 0;
          break;
        case SurfaceDefect::kSlow:
          servo.rate_share *= fault.rate_share;
          break;
      }
    });
    return health;
  }

  /// A shifted centre of gravity gives the surface forces an arm: torque -d x F about the old one,
  /// with the F = m (a - g) of the step before. The inertia's change with the shift is left out.
  void shift_cg(World& world) const {
    Eigen::Vector3d shift_B = Eigen::Vector3d::Zero();
    for_active<CgFault>([&](const CgFault& fault) { shift_B += fault.shift_B_m; });
    if (shift_B.isZero(0.0)) return;
    const BodyState& state = world.state(vehicle_);
    const Eigen::Vector3d gravity_W = world.environment(vehicle_).gravity_W;
    const Eigen::Vector3d force_B =
        world.mass_kg(vehicle_) * (state.q_WB.conjugate() * (state.a_WB - gravity_W));
    world.add_wrench(vehicle_, {Eigen::Vector3d::Zero(), -shift_B.cross(force_B)});
  }

  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  base::NormalRandom random_;
  FaultSchedule schedule_;
  std::vector<FaultEvent> events_;
  base::Vehicle airframe_;
  std::vector<std::string> further_;  // sensors beside the first of a kind
  bool by_hand_ = false;              // takes orders while it flies
  bool breaks_propulsion_ = false;
  bool breaks_surfaces_ = false;
  bool changes_mass_ = false;
  bool blows_ = false;
  bool blows_at_nothing_ = false;
  bool cuts_line_ = false;
  bool armed_ = false;
  FlightPhase phase_;
  std::vector<double> torque_coefficients_;
  double hover_power_ = 0;
  double power_ = 0;  // k_m w^3 of all rotors
  std::vector<double> hover_rad_s_;
  std::vector<double> turned_rad_;  // by each rotor
  double vibration_ = 0;            // see BiasDriver::kVibration
  std::tuple<Taps<ImuSample>, Taps<GpsSample>, Taps<MagnetometerSample>, Taps<BarometerSample>,
             Taps<RangeSample>, Taps<AirspeedSample>, Taps<FlowSample>, Taps<OdometrySample>,
             Taps<LandingTargetSample>>
      taps_;
  Publisher<PropulsionHealth> health_;
  Publisher<SurfaceHealth> surface_health_;
  Publisher<GustCommand> gust_;
  Publisher<LineCut> line_cut_;
  Subscription command_;
  Subscription rotor_speeds_;
  Subscription phase_topic_;
  Subscription orders_;
  Subscription station_orders_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::FaultPlugin, "fault")

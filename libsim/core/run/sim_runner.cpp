// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/sim_runner.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/angles.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "base/os/log.hpp"
#include "base/os/result_file.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "libsim/api/terrain_source.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/load/plausibility.hpp"
#include "libsim/core/load/world_loader.hpp"
#include "libsim/core/ode/contact_solver.hpp"
#include "libsim/core/run/beacons.hpp"
#include "libsim/core/run/left_world.hpp"
#include "libsim/core/run/plugin_host.hpp"
#include "libsim/core/run/sim_world.hpp"
#include "libsim/core/run/start.hpp"
#include "libsim/core/terrain/terrain.hpp"

namespace cas::sim {

namespace {

constexpr base::Duration kDefaultStep = std::chrono::milliseconds(1);
/// Longest single wait for a peer, so that an interrupt is noticed.
constexpr base::Duration kWaitSlice = std::chrono::milliseconds(50);
/// A vehicle file and its URDF may round, not disagree.
constexpr double kMassTolerance = 0.01;
constexpr const char* kFiguresFile = "plugin_figures.json";

std::optional<std::string> other_mass(const VehicleConfig& vehicle, const VehicleModel& model) {
  const double model_kg = model.mass.mass_kg();
  if (std::abs(model_kg - vehicle.vehicle.mass_kg) <= kMassTolerance * model_kg) {
    return std::nullopt;
  }
  return fmt::format("{}: the model weighs {:f} kg, which is flown; the vehicle file says {:f} kg",
                     vehicle.name, model_kg, vehicle.vehicle.mass_kg);
}

/// A controller that knows the Earth's field at its place takes the difference for its own heading.
std::optional<std::string> other_field(const WorldModel& model, const base::Geodetic& home,
                                       double decimal_year) {
  if (!model.magnetic_field_W) return std::nullopt;
  constexpr double kNoticeable_deg = 3;
  const Eigen::Vector3d own_N = base::swap_WN(*model.magnetic_field_W);
  const Eigen::Vector3d earth_N = base::magnetic_field_N(home, decimal_year);
  const double east_deg = base::kDegPerRad * base::wrap_angle(std::atan2(own_N.y(), own_N.x()) -
                                                              std::atan2(earth_N.y(), earth_N.x()));
  if (std::abs(east_deg) < kNoticeable_deg) return std::nullopt;
  return fmt::format(
      "world {}: its <magnetic_field> points {:.1f} degrees {} of the Earth's at home: a "
      "controller "
      "that expects the Earth's is off by as much in its heading; without the element it gets the "
      "Earth's",
      model.name, std::abs(east_deg), east_deg > 0 ? "east" : "west");
}

}  // namespace

struct SimRunner::Impl {
  Impl(SimConfig config_in, SimOptions options_in)
      : config(std::move(config_in)),
        options(std::move(options_in)),
        model(load_world(config)),
        step(config.step.value_or(model.step.value_or(kDefaultStep))),
        world(model, base::LocalProjection(home_of(config, model)), config.decimal_year,
              config.integrator),
        plugins(options.plugin_dirs) {
    warn("", model.warnings);
    warn("", other_field(model, world.projection().home(), config.decimal_year));
    warn("", implausible_gravity(model.gravity_W));
    if (!config.pace.speed_given) config.pace.speed = model.real_time_factor.value_or(1.0);
    for (VehicleConfig& vehicle : config.vehicles) add_vehicle(vehicle);
  }

  void add_vehicle(VehicleConfig& vehicle) {
    const VehicleModel& vehicle_model = vehicle_models.emplace_back(
        load_vehicle_model(vehicle.vehicle.urdf, vehicle.vehicle.parts, config.world.up_axis));
    warn(vehicle.name, vehicle.vehicle.warnings);
    warn(vehicle.name, vehicle_model.warnings);
    warn(vehicle.name, other_mass(vehicle, vehicle_model));
    warn(vehicle.name, implausible(vehicle.vehicle, vehicle_model));
    if (!vehicle.pose.z_m) vehicle.pose.z_m = standing_height(world, vehicle_model, vehicle.pose);
    require_free_start(world, model, vehicle_model, vehicle);
    if (config.world.sdf) require_ground(world, model, vehicle_model, vehicle, *config.world.sdf);
    plugins.load(world.add_vehicle(vehicle_model, vehicle.pose), vehicle);
  }

  /// Logs and keeps sentences. @param sentences  a range of them, or one that there may be
  template <class Sentences>
  void warn(const std::string& vehicle, const Sentences& sentences) {
    if constexpr (requires { sentences.has_value(); }) {
      if (sentences) warn(vehicle, std::vector{*sentences});
    } else {
      for (const std::string& sentence : sentences) {
        base::log::warn(sentence);
        warnings.push_back({vehicle, sentence});
      }
    }
  }

  /// What is connected to nothing. @param unsent  labels of plugins: "battery@iris0"
  void warn_of_idle(const std::vector<std::string>& unsent) {
    for (const std::string& label : unsent) {
      const std::string vehicle = label.substr(label.find('@') + 1);
      warn(vehicle.substr(0, vehicle.find('#')),
           std::optional("plugin " + label +
                         ": its MAVLink messages are not sent, because the "
                         "vehicle has no mavlink_interface"));
    }
    for (const std::string& topic : bus.unpublished()) {
      warn(topic.substr(0, topic.find('/')),
           std::optional("topic '" + topic + "' has subscribers and no publisher"));
    }
  }

  /// The motion in contact is not to be trusted where the solver found no forces.
  void warn_of_contacts() {
    const std::uint64_t count = ContactSolver::complaints() - complaints_before;
    if (count == 0) return;
    warn("", std::optional(fmt::format("the contact solver complained {} times of contacts that "
                                       "contradict each other; the motion in them is doubtful",
                                       count)));
  }

  /// @throws LeftWorldError
  void require_in_world(VehicleId id) const {
    if (!world.is_below_everything(id)) return;
    const Eigen::Vector3d& p_W = world.state(id).p_WB;
    throw LeftWorldError(fmt::format(
        "vehicle '{}' has fallen out of the world: at {:.3f} s it is at x {:.1f}, y {:.1f}, z "
        "{:.1f} m, below everything that is there",
        config.vehicles[static_cast<std::size_t>(id)].name, base::to_seconds(time), p_W.x(),
        p_W.y(), p_W.z()));
  }

  /// @throws LeftWorldError
  void advance() {
    try {
      world.advance(base::to_seconds(step));
    } catch (const SolverFailure& failure) {
      throw LeftWorldError(fmt::format("at {:.3f} s {}; hilsim --describe names what stands out",
                                       base::to_seconds(time), failure.what()));
    }
  }

  bool interrupted() const { return interrupt != nullptr && interrupt->load(); }

  /// Lockstep: holds the step until every control due for the sensors sent so far is there.
  /// @return false when one did not come
  bool wait_for_peers() {
    if (config.pace.mode != PaceMode::kLockstep) return true;
    bool all = true;
    for (LockstepPeer* peer : plugins.peers()) {
      if (!peer->in_step()) continue;
      bool arrived = false;
      for (base::Duration waited{};
           !arrived && waited < config.pace.lockstep_timeout && !interrupted();
           waited += kWaitSlice) {
        arrived = peer->wait_for_controls(
            time, std::min(kWaitSlice, config.pace.lockstep_timeout - waited));
      }
      if (arrived) continue;
      ++lockstep_timeouts;
      peer->give_up();
      all = false;
    }
    return all;
  }

  SimConfig config;
  SimOptions options;
  WorldModel model;
  std::vector<VehicleModel> vehicle_models;
  std::vector<SimWarning> warnings;
  base::Duration step;
  TopicBus bus;
  SimWorld world;
  PluginHost plugins;  // last: plugins are destroyed before their topics
  std::vector<Publisher<FlightPhase>> phases;
  base::SimTime time{};
  std::uint64_t steps = 0;
  std::uint64_t lockstep_timeouts = 0;
  std::uint64_t complaints_before = ContactSolver::complaints();
  bool finished = false;
  const std::atomic<bool>* interrupt = nullptr;
};

SimRunner::SimRunner(SimConfig config, SimOptions options)
    : impl_(std::make_unique<Impl>(std::move(config), std::move(options))) {}

SimRunner::~SimRunner() = default;

TopicBus& SimRunner::bus() { return impl_->bus; }

void SimRunner::start() {
  const PluginSurroundings around{impl_->bus, impl_->world, impl_->step, impl_->config.seed,
                                  impl_->options.output_dir};
  for (const VehicleConfig& vehicle : impl_->config.vehicles) {
    impl_->phases.push_back(impl_->bus.advertise<FlightPhase>(vehicle.name + "/flight_phase"));
  }
  const auto terrain = impl_->bus.advertise<TerrainSource>("terrain");
  std::vector<Publisher<BeaconSource>> beacons;
  for (const BeaconConfig& beacon : impl_->config.beacons) {
    beacons.push_back(impl_->bus.advertise<BeaconSource>(BeaconSource::topic(beacon.name)));
  }
  const auto unsent = impl_->plugins.configure(impl_->config.vehicles, around);
  impl_->bus.freeze();
  impl_->warn_of_idle(unsent);
  if (impl_->model.terrain) {
    base::log::info(impl_->model.terrain->description());
    terrain.publish({[ground = impl_->model.terrain](double lat_deg, double lon_deg) {
      return ground->elevation_m(lat_deg, lon_deg).value_or(0);
    }});
  }
  for (std::size_t i = 0; i < beacons.size(); ++i) {
    beacons[i].publish(beacon_source(impl_->config.beacons[i], impl_->model, impl_->world));
  }
  impl_->world.start();
}

void SimRunner::step() {
  Impl& s = *impl_;
  const base::SimTime end = s.time + s.step;

  // Lockstep: the controls for the sensors sent so far.
  s.wait_for_peers();

  // Controls become forces; wind blows; faults strike.
  s.plugins.pre_step({.time = s.time, .dt = s.step, .index = s.steps}, s.world);

  // Bodies and rotors move.
  s.advance();

  // Sensors measure; interfaces send.
  s.time = end;
  s.plugins.post_step({.time = end, .dt = s.step, .index = s.steps}, s.world);
  ++s.steps;
  for (std::size_t i = 0; i < s.config.vehicles.size(); ++i) {
    s.require_in_world(static_cast<VehicleId>(i));
  }
}

void SimRunner::reset() {
  impl_->time = {};
  impl_->steps = 0;
  impl_->lockstep_timeouts = 0;
  impl_->plugins.reset();
  impl_->world.reset();
}

void SimRunner::finish() {
  if (std::exchange(impl_->finished, true)) return;
  impl_->plugins.finish();
  impl_->warn_of_contacts();
  const FigureBook& figures = impl_->plugins.figures();
  if (figures.empty()) return;
  base::write_result({impl_->options.output_dir, kFiguresFile}, figures.json());
}

bool SimRunner::settled() {
  if (!impl_->wait_for_peers()) return true;
  const auto& peers = impl_->plugins.peers();
  return impl_->config.pace.mode != PaceMode::kLockstep ||
         std::all_of(peers.begin(), peers.end(),
                     [](const LockstepPeer* peer) { return !peer->in_step() || peer->settled(); });
}

base::SimTime SimRunner::time() const { return impl_->time; }
base::Duration SimRunner::step_size() const { return impl_->step; }
std::uint64_t SimRunner::steps() const { return impl_->steps; }
const World& SimRunner::world() const { return impl_->world; }
const SimConfig& SimRunner::config() const { return impl_->config; }
const WorldModel& SimRunner::world_model() const { return impl_->model; }
const std::vector<VehicleModel>& SimRunner::vehicle_models() const { return impl_->vehicle_models; }
const std::vector<SimWarning>& SimRunner::warnings() const { return impl_->warnings; }
std::uint64_t SimRunner::lockstep_timeouts() const { return impl_->lockstep_timeouts; }
bool SimRunner::peers_in_step() const {
  const auto& peers = impl_->plugins.peers();
  return std::all_of(peers.begin(), peers.end(),
                     [](const LockstepPeer* peer) { return peer->in_step(); });
}
void SimRunner::set_interrupt(const std::atomic<bool>* flag) { impl_->interrupt = flag; }

void SimRunner::set_flight_phase(std::string_view name) {
  FlightPhase phase;
  name.copy(phase.name.data(), phase.name.size() - 1);
  for (const auto& publisher : impl_->phases) publisher.publish(phase);
}

std::vector<std::string> SimRunner::vehicle_names() const {
  std::vector<std::string> names;
  for (const VehicleConfig& vehicle : impl_->config.vehicles) names.push_back(vehicle.name);
  return names;
}

std::vector<PluginFigures> SimRunner::plugin_figures() const {
  std::vector<PluginFigures> figures;
  for (const PluginInstance& p : impl_->plugins.plugins()) {
    if (std::string json = p.plugin->stats_json(); !json.empty()) {
      figures.push_back({p.label, std::move(json)});
    }
  }
  return figures;
}

}  // namespace cas::sim

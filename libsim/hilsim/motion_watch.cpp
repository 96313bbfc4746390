// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/motion_watch.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libsim/api/messages.hpp"
#include "libsim/api/point_cloud.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/hilsim/round_json.hpp"

namespace cas::sim {

namespace {

using Json = nlohmann::json;

// Tolerances of a picture.
constexpr double kLength = 1e-4;  // m
constexpr double kTurn = 1e-5;
constexpr double kSpeed = 1e-3;             // m/s, rad/s
constexpr double kRotor = 1e-1;             // rad/s
constexpr double kDeflection = 1e-3;        // rad
constexpr double kReturn = 1e-2;            // m
constexpr std::size_t kMostReturns = 1500;  // of a scan

/// Latest values that the plugins of one vehicle published. Written and read on the simulation
/// thread.
struct Newest {
  base::RotorVector omega_rad_s;
  ActuatorValues deflections_rad = ActuatorValues::Zero(0);
  std::optional<RangeSample> range;
  std::size_t rays = 0;  // rangefinders, as in the scene
  /// Newest scan of each lidar; nothing before the first.
  std::vector<std::shared_ptr<const std::vector<Eigen::Vector3f>>> clouds;
};

std::size_t count_plugins(const VehicleConfig& vehicle, std::string_view name) {
  return static_cast<std::size_t>(std::ranges::count(vehicle.plugins, name, &PluginConfig::plugin));
}

Newest before_the_first_step(const VehicleConfig& vehicle) {
  Newest newest;
  newest.omega_rad_s = base::RotorVector::Zero(vehicle.vehicle.rotor_count());
  newest.rays = count_plugins(vehicle, kRangefinder);
  newest.clouds.resize(count_plugins(vehicle, "lidar"));
  return newest;
}

/// The values of each rotor or control surface.
template <class Values>
Json each_json(const Values& values, double tolerance) {
  Json each = Json::array();
  for (const double value : values) each.push_back(rounded(value, tolerance));
  return each;
}

Json rays_json(const Newest& newest) {
  Json rays = Json::array();
  const auto& range = newest.range;
  for (std::size_t i = 0; i < newest.rays; ++i) {
    rays.push_back(range && range->valid ? Json(rounded(range->distance_m, kLength)) : Json());
  }
  return rays;
}

}  // namespace

struct MotionWatch::Sample {
  struct Vehicle {
    BodyState state;
    bool in_contact = false;
    Newest newest;
  };
  LoopFigures figures;
  Eigen::Vector3d wind_W = Eigen::Vector3d::Zero();  // at the first vehicle
  std::vector<Vehicle> vehicles;
};

struct MotionWatch::Impl {
  SimLoop& loop;
  std::vector<std::unique_ptr<Newest>> newest;  // each where its subscriptions find it
  std::vector<Subscription> subscriptions;
};

MotionWatch::MotionWatch(SimLoop& loop) : impl_(new Impl{loop, {}, {}}) {
  TopicBus& bus = loop.runner().bus();
  for (const VehicleConfig& vehicle : std::as_const(loop).runner().config().vehicles) {
    Newest& newest =
        *impl_->newest.emplace_back(std::make_unique<Newest>(before_the_first_step(vehicle)));
    const std::string& name = vehicle.name;
    impl_->subscriptions.push_back(bus.subscribe<RotorSpeeds>(
        name + "/rotor_speeds",
        [&newest](const RotorSpeeds& speeds) { newest.omega_rad_s = speeds.omega_rad_s; },
        Need::kOptional));
    impl_->subscriptions.push_back(bus.subscribe<SurfaceDeflections>(
        name + "/surface_deflections",
        [&newest](const SurfaceDeflections& surfaces) {
          newest.deflections_rad = surfaces.angle_rad;
        },
        Need::kOptional));
    impl_->subscriptions.push_back(bus.subscribe<RangeSample>(
        name + "/" + kRangefinder, [&newest](const RangeSample& range) { newest.range = range; },
        Need::kOptional));
    for (std::size_t i = 0; i < newest.clouds.size(); ++i) {
      impl_->subscriptions.push_back(bus.subscribe<PointCloud>(
          name + "/" + lidar_topic(static_cast<int>(i) + 1),
          [&cloud = newest.clouds[i]](const PointCloud& scan) {
            cloud = std::make_shared<const std::vector<Eigen::Vector3f>>(
                drawn_points(scan, kMostReturns));
          },
          Need::kOptional));
    }
  }
}

MotionWatch::~MotionWatch() = default;

std::shared_ptr<const MotionWatch::Sample> MotionWatch::take() const {
  const SimRunner& runner = impl_->loop.runner();
  const World& world = runner.world();
  auto sample = std::make_shared<Sample>();
  sample->figures = impl_->loop.figures();
  for (std::size_t i = 0; i < impl_->newest.size(); ++i) {
    const auto id = static_cast<VehicleId>(i);
    Newest newest = *impl_->newest[i];
    // After a reset the newest values are the last run's until the plugins publish again.
    if (sample->figures.steps == 0) newest = before_the_first_step(runner.config().vehicles[i]);
    if (newest.range && newest.range->time > sample->figures.time) newest.range.reset();
    sample->vehicles.push_back({world.state(id), world.in_contact(id), std::move(newest)});
  }
  if (!impl_->newest.empty()) sample->wind_W = world.environment(VehicleId{}).wind_W;
  return sample;
}

Json MotionWatch::json(const Sample& sample) const {
  const LoopFigures& f = sample.figures;
  Json vehicles = Json::array();
  for (const Sample::Vehicle& vehicle : sample.vehicles) {
    vehicles.push_back({{"p", rounded(vehicle.state.p_WB, kLength)},
                        {"q", rounded(vehicle.state.q_WB, kTurn)},
                        {"vel", rounded(vehicle.state.v_WB, kSpeed)},
                        {"w", rounded(vehicle.state.w_WB_B, kSpeed)},
                        {"rotors", each_json(vehicle.newest.omega_rad_s, kRotor)},
                        {"surfaces", each_json(vehicle.newest.deflections_rad, kDeflection)},
                        {"contact", vehicle.in_contact ? 1 : 0},
                        {"rays", rays_json(vehicle.newest)}});
  }
  Json obstacles = Json::array();
  const double time_s = base::to_seconds(f.time);
  for (const MovingObstacle& obstacle : impl_->loop.runner().world_model().moving) {
    const BodyState state = obstacle.path.at(time_s);
    obstacles.push_back({{"p", rounded(state.p_WB, kLength)}, {"q", rounded(state.q_WB, kTurn)}});
  }
  return {{"t_s", rounded(time_s, 1e-6)},
          {"steps", f.steps},
          {"rate", rounded(f.real_time_factor, 1e-3)},
          {"paused", f.paused},
          {"late_steps", f.late_steps},
          {"v", std::move(vehicles)},
          {"wind_W", rounded(sample.wind_W, kSpeed)},
          {"o", std::move(obstacles)}};
}

Json MotionWatch::clouds_json(const Sample& sample) {
  Json vehicles = Json::array();
  for (const Sample::Vehicle& vehicle : sample.vehicles) {
    Json& returns = vehicles.emplace_back(Json::array());
    for (const auto& cloud : vehicle.newest.clouds) {
      if (!cloud) continue;
      for (const Eigen::Vector3f& p_W : *cloud) {
        for (const double value : p_W) returns.push_back(rounded(value, kReturn));
      }
    }
  }
  return {{"t_s", rounded(base::to_seconds(sample.figures.time), 1e-6)},
          {"v", std::move(vehicles)}};
}

}  // namespace cas::sim

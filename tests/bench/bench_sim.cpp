// SPDX-License-Identifier: BSD-3-Clause
// Where the time of a simulated step goes: each part alone, then whole worlds.
// A `real_time` counter tells how many simulated seconds pass in a second of one core.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "base/earth/atmosphere.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "plugins/aero/aero_model.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/libsim/support/four_rotors.hpp"
#include "tests/libsim/support/triangles.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas;
using namespace cas::sim;

constexpr double kStep = 1e-3;
constexpr VehicleId kFirst{0};

void count_steps(benchmark::State& state, double vehicles = 1) {
  state.SetItemsProcessed(state.iterations());
  state.counters["real_time"] = benchmark::Counter(static_cast<double>(state.iterations()) * kStep,
                                                   benchmark::Counter::kIsRate);
  state.counters["per_vehicle"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * vehicles,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void integrate_body(benchmark::State& state) {
  BodyState body;
  body.w_WB_B = {0.1, 0.2, 0.3};
  ForceSet none;
  const MassProperties mass(1.5, Eigen::Vector3d(0.03, 0.03, 0.056).asDiagonal());
  for (auto _ : state) {
    integrate_free(body, none, mass, {}, {}, kStep);
    benchmark::DoNotOptimize(body);
  }
  count_steps(state);
}
BENCHMARK(integrate_body);

void integrate_body_and_rotors(benchmark::State& state) {
  BodyState body;
  sim::test::FourRotors rotors(Eigen::Vector4d(800, 805, 800, 805));
  ForceSet forces;
  forces.add(rotors);
  const MassProperties mass(1.5, Eigen::Vector3d(0.03, 0.03, 0.056).asDiagonal());
  for (auto _ : state) {
    integrate_free(body, forces, mass, {}, {}, kStep);
    benchmark::DoNotOptimize(body);
  }
  count_steps(state);
}
BENCHMARK(integrate_body_and_rotors);

/// A plane at its cruising speed; the difference to integrate_body is its wings'.
void integrate_plane(benchmark::State& state, const char* path) {
  const auto file = std::filesystem::path(cas::test::source_dir()) / path;
  const base::Vehicle vehicle = base::Vehicle::load(file);
  AeroModel aero(*vehicle.aero);
  ForceSet forces;
  forces.add(aero);
  forces.reset_states();
  const MassProperties mass(vehicle.mass_kg, vehicle.inertia_kg_m2.asDiagonal());
  Environment air;
  air.air_density_kg_m3 = base::isa::density_kg_m3(0);
  BodyState start;
  start.v_WB = {vehicle.aero->cruise_m_s, 0, -0.5};
  BodyState body = start;
  for (auto _ : state) {
    body.v_WB = start.v_WB;
    body.w_WB_B = {0.1, 0.2, 0.3};
    integrate_free(body, forces, mass, air, {}, kStep);
    benchmark::DoNotOptimize(body);
  }
  count_steps(state);
}
BENCHMARK_CAPTURE(integrate_plane, of_derivatives, "config/vehicles/aerosonde.yaml");
BENCHMARK_CAPTURE(integrate_plane, of_six_panels, "tests/plugins/data/panel_plane.yaml");

void world_free(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::flat_world());
  world->add_vehicle(sim::test::crate(), {.z_m = 1e6});
  world->start();
  for (auto _ : state) world->advance(kStep);
  count_steps(state);
}
BENCHMARK(world_free);

/// In reach of the ground, not touching it: narrow phase, no contact.
void world_near_ground(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::flat_world());
  world->add_vehicle(sim::test::crate(), {.z_m = 0.1});
  sim::test::SteadyThrust hover(sim::test::kCrateMass * sim::test::kGravity);
  world->add_force_model(kFirst, hover);
  world->start();
  for (auto _ : state) world->advance(kStep);
  count_steps(state);
}
BENCHMARK(world_near_ground);

void world_contact(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::flat_world());
  world->add_vehicle(sim::test::crate(), {});
  world->start();
  double sign = 1;
  for (auto _ : state) {
    world->add_wrench(kFirst, {{sign = -sign, 0, 0}, Eigen::Vector3d::Zero()});
    world->advance(kStep);
  }
  count_steps(state);
}
BENCHMARK(world_contact);

/// The same on flat triangles of 10 cm, of which some 60 are touched.
void world_contact_triangles(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::ground_of_triangles(0.1));
  world->add_vehicle(sim::test::crate(), {});
  world->start();
  double sign = 1;
  for (auto _ : state) {
    world->add_wrench(kFirst, {{sign = -sign, 0, 0}, Eigen::Vector3d::Zero()});
    world->advance(kStep);
  }
  count_steps(state);
}
BENCHMARK(world_contact_triangles);

/// Sliding over them: a collision is looked for each 10 cm.
void world_slide_triangles(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::ground_of_triangles(0.1, 0.1));
  world->add_vehicle(sim::test::crate(), {});
  world->start();
  double side = 6;  // N, beyond friction
  for (auto _ : state) {
    const double x = world->state(kFirst).p_WB.x();
    if (std::abs(x) > 0.5) side = std::copysign(6.0, -x);
    world->add_wrench(kFirst, {{side, 0, 0}, Eigen::Vector3d::Zero()});
    world->advance(kStep);
  }
  count_steps(state);
}
BENCHMARK(world_slide_triangles);

void world_held(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::flat_world());
  world->add_vehicle(sim::test::crate(), {});
  world->start();
  for (auto _ : state) world->advance(kStep);
  count_steps(state);
}
BENCHMARK(world_held);

/// ODE's own stepper in free flight, for comparison.
void world_ode(benchmark::State& state) {
  const auto world = sim::test::make_world(sim::test::flat_world(), Integrator::kOde);
  world->add_vehicle(sim::test::crate(), {.z_m = 1e6});
  world->start();
  for (auto _ : state) world->advance(kStep);
  count_steps(state);
}
BENCHMARK(world_ode);

void air_density(benchmark::State& state) {
  double altitude = 488;
  for (auto _ : state) benchmark::DoNotOptimize(base::isa::density_kg_m3(altitude += 1e-3));
}
BENCHMARK(air_density);

// Whole simulations of shipped vehicles through their plugin libraries.

std::string vehicles(int count, const std::string& plugins, const std::string& name) {
  std::string list;
  for (int i = 0; i < count; ++i) {
    const std::string n = std::to_string(i);
    list += "  - {name: v" + n + ", vehicle: " + cas::test::source_dir() + "/config/vehicles/" +
            name + ".yaml, pose: {x_m: " + std::to_string(5 * i) + ", z_m: 100000}, plugins: [" +
            plugins + "]}\n";
  }
  return list;
}

std::unique_ptr<SimRunner> simulation(int count, const std::string& plugins,
                                      const std::string& name) {
  auto runner = std::make_unique<SimRunner>(
      SimConfig::parse(base::ConfigNode::parse(
          "schema: 1\nworld: {gravity_m_s2: 9.80665, ground: true}\n"
          "home: {lat_deg: 47.4, lon_deg: 8.5, alt_m: 488}\ndecimal_year: 2026.5\n"
          "pace: free_run\nvehicles:\n" +
              vehicles(count, plugins, name),
          "bench")),
      SimOptions{.output_dir = std::filesystem::temp_directory_path(),
                 .plugin_dirs = {std::filesystem::path(cas::test::binary_dir()) / "plugins"}});
  runner->start();
  return runner;
}

const std::string kMotor = "{plugin: motor}";
const std::string kSensors =
    "{plugin: imu}, {plugin: gps}, {plugin: magnetometer}, {plugin: barometer}";
const std::string kBus =
    "{plugin: mavlink_interface, transport: bus, system_id: 1, component_id: 200}";

void run_simulation(benchmark::State& state, const std::string& plugins, int count,
                    const std::string& vehicle = "iris_paper") {
  const auto runner = simulation(count, plugins, vehicle);
  for (auto _ : state) runner->step();
  count_steps(state, count);
}

void simulate_bare(benchmark::State& state) { run_simulation(state, "", 1); }
void simulate_motor(benchmark::State& state) { run_simulation(state, kMotor, 1); }
void simulate_motor_imu(benchmark::State& state) {
  run_simulation(state, kMotor + ", {plugin: imu}", 1);
}
void simulate_motor_gps(benchmark::State& state) {
  run_simulation(state, kMotor + ", {plugin: gps}", 1);
}
void simulate_motor_magnetometer(benchmark::State& state) {
  run_simulation(state, kMotor + ", {plugin: magnetometer}", 1);
}
void simulate_motor_barometer(benchmark::State& state) {
  run_simulation(state, kMotor + ", {plugin: barometer}", 1);
}
void simulate_all_sensors(benchmark::State& state) {
  run_simulation(state, kMotor + ", " + kSensors, static_cast<int>(state.range(0)));
}
void simulate_hexarotor(benchmark::State& state) {
  run_simulation(state, kMotor + ", " + kSensors, 1, "hexa_x");
}
void simulate_all_and_packets(benchmark::State& state) {
  run_simulation(state, kMotor + ", " + kSensors + ", " + kBus, static_cast<int>(state.range(0)));
}
BENCHMARK(simulate_bare);
BENCHMARK(simulate_motor);
BENCHMARK(simulate_motor_imu);
BENCHMARK(simulate_motor_gps);
BENCHMARK(simulate_motor_magnetometer);
BENCHMARK(simulate_motor_barometer);
BENCHMARK(simulate_all_sensors)->Arg(1)->Arg(2)->Arg(5)->Arg(10)->Arg(20);
BENCHMARK(simulate_hexarotor);
BENCHMARK(simulate_all_and_packets)->Arg(1)->Arg(20);

}  // namespace

BENCHMARK_MAIN();

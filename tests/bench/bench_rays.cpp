// SPDX-License-Identifier: BSD-3-Clause
// Rays into 527 000 triangles (hills of 1 km by 1 km, 400 houses), by Embree and by ODE, and lidars
// on vehicles above them. `rays` counts rays in a second of one core, `real_time` simulated seconds
// in a second of one core.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include "base/random.hpp"
#include "plugins/lidar/lidar_model.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas;
using namespace cas::sim;
using Eigen::Vector3d;

constexpr double kRange_m = 100;

double height_of_hills(double x, double y) {
  return 8 * std::sin(0.02 * x) * std::cos(0.017 * y) + 2 * std::sin(0.11 * x + 0.07 * y);
}

Shape hills() {
  constexpr int kCells = 512;
  const auto mesh = std::make_shared<TriangleMesh>();
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const double x = -500 + 1000.0 * i / kCells;
      const double y = -500 + 1000.0 * j / kCells;
      mesh->vertices.emplace_back(x, y, height_of_hills(x, y));
    }
  }
  const auto corner = [](int i, int j) { return static_cast<std::uint32_t>(j * (kCells + 1) + i); };
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      mesh->triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      mesh->triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  }
  return sim::test::standing("hills", Mesh{mesh});
}

std::unique_ptr<SimWorld> hills_with_houses(int vehicles, bool by_embree) {
  WorldModel model;
  model.statics.push_back(hills());
  base::NormalRandom random(1);
  for (int i = 0; i < 400; ++i) {
    const double x = 800 * random.uniform() - 400;
    const double y = 800 * random.uniform() - 400;
    model.statics.push_back(
        sim::test::standing("house", Box{{10, 8, 9}}, {x, y, height_of_hills(x, y) + 3.5}));
  }
  auto world = sim::test::make_world(model);
  for (int i = 0; i < vehicles; ++i) {
    const double x = -200 + 15.0 * i;
    world->add_vehicle(sim::test::crate(),
                       {.x_m = x, .y_m = -150, .z_m = height_of_hills(x, -150) + 12});
  }
  if (by_embree) world->expect_rays();
  world->start();
  return world;
}

LidarParams vlp16() {
  return {.beams = load_lidar_pattern(std::filesystem::path(cas::test::source_dir()) /
                                      "config/lidars/vlp16.yaml")
                       .beams,
          .rate_hz = 10,
          .min_m = 0.5,
          .max_m = kRange_m,
          .obstacle_height_m = 1};
}

/// All rays of a turn, from ten places.
void cast_turn(benchmark::State& state, bool by_embree) {
  const auto world = hills_with_houses(1, by_embree);
  const std::vector<LidarBeam> beams = vlp16().beams;
  std::vector<Vector3d> directions;
  for (const LidarBeam& beam : beams) directions.push_back(beam.direction_S);
  std::vector<Vector3d> origins(beams.size());
  std::vector<RayHit> hits(beams.size());
  int place = 0;
  for (auto _ : state) {
    const double x = -200 + 40 * (place % 10);
    const double y = -150 + 30 * (place % 10);
    std::ranges::fill(origins, Vector3d(x, y, height_of_hills(x, y) + 12));
    ++place;
    world->cast(VehicleId{0}, origins, directions, kRange_m, hits);
    benchmark::DoNotOptimize(hits.data());
  }
  state.counters["rays"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(beams.size()),
      benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(cast_turn, by_embree, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(cast_turn, by_ode, false)->Unit(benchmark::kMillisecond);

/// A step of 4 ms with a VLP-16 on each vehicle: aiming, rays, returns, sectors.
void lidar_step(benchmark::State& state) {
  constexpr double kStep_s = 0.004;
  const int count = static_cast<int>(state.range(0));
  const auto world = hills_with_houses(count, true);
  std::vector<LidarModel> lidars;
  for (int i = 0; i < count; ++i) lidars.emplace_back(vlp16(), i + 1, [](const LidarScan&) {});
  std::int64_t step = 0;
  for (auto _ : state) {
    const auto time = [](std::int64_t n) {
      return base::SimTime(base::from_seconds(static_cast<double>(n) * kStep_s));
    };
    for (int i = 0; i < count; ++i) {
      const VehicleId vehicle{static_cast<std::uint32_t>(i)};
      LidarModel& lidar = lidars[static_cast<std::size_t>(i)];
      lidar.aim(time(step), time(step + 1), world->state(vehicle), world->state(vehicle));
      world->cast(vehicle, lidar.origins_W(), lidar.directions_W(), kRange_m, lidar.hits());
      lidar.take_hits();
    }
    ++step;
  }
  state.counters["real_time"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * kStep_s, benchmark::Counter::kIsRate);
}
BENCHMARK(lidar_step)->Arg(1)->Arg(4)->Unit(benchmark::kMicrosecond);

/// What a scene costs at the start.
void make_scene(benchmark::State& state) {
  const std::vector<Shape> shapes{hills()};
  for (auto _ : state) benchmark::DoNotOptimize(make_ray_scene(shapes));
}
BENCHMARK(make_scene)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();

// SPDX-License-Identifier: BSD-3-Clause
// What one update of the emulated controller costs, and which part of it costs how much.
// `update_in_flight` flies a recorded hover again, packet by packet, and times each HIL_SENSOR
// alone.
#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "base/measure/histogram.hpp"
#include "fcu/control/control_allocation.hpp"
#include "fcu/control/control_cascade.hpp"
#include "fcu/control/mixer.hpp"
#include "fcu/estimation/estimator.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "tests/fcu/support/closed_loop.hpp"
#include "tests/fcu/support/frames.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas;
using namespace cas::fcu;
using Eigen::Vector3d;

constexpr base::Duration kSamplePeriod = std::chrono::milliseconds(2);
const base::Geodetic kHome{47.397742, 8.545594, 488.0};
const Vector3d kField_D{0.21, 0.01, 0.43};

base::Vehicle iris() {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/iris_paper.yaml");
}

// The estimator.

/// An aligned estimator at rest, moved on by its IMU.
class RestingEstimator {
 public:
  RestingEstimator() : estimator_({}, 2026.5) {
    estimator_.set_origin(kHome);
    for (int i = 0; i < 1000; ++i) {
      imu();
      estimator_.on_magnetometer(time_, kField_D);
      if (i % 100 == 0) gps();
    }
  }
  void imu() {
    time_ += kSamplePeriod;
    estimator_.on_imu({time_, {1e-4, 0, 0}, {0, 0, -9.80665}});
  }
  void magnetometer() { estimator_.on_magnetometer(time_, kField_D); }
  void barometer() { estimator_.on_barometer(time_, 95600); }
  void gps() { estimator_.on_gps({time_, 3, kHome, Vector3d::Zero()}); }
  const Estimator& get() const { return estimator_; }

 private:
  Estimator estimator_;
  base::SimTime time_{std::chrono::seconds(1)};
};

void estimator_predict(benchmark::State& state) {
  RestingEstimator estimator;
  for (auto _ : state) estimator.imu();
  benchmark::DoNotOptimize(estimator.get().state());
}
BENCHMARK(estimator_predict);

/// Each fusion with the prediction before it: time stands still for none.
template <void (RestingEstimator::*fuse)()>
void estimator_predict_and_fuse(benchmark::State& state) {
  RestingEstimator estimator;
  for (auto _ : state) {
    estimator.imu();
    (estimator.*fuse)();
  }
  benchmark::DoNotOptimize(estimator.get().state());
}
BENCHMARK(estimator_predict_and_fuse<&RestingEstimator::magnetometer>)
    ->Name("estimator_predict_and_fuse_magnetometer");
BENCHMARK(estimator_predict_and_fuse<&RestingEstimator::barometer>)
    ->Name("estimator_predict_and_fuse_barometer");
BENCHMARK(estimator_predict_and_fuse<&RestingEstimator::gps>)
    ->Name("estimator_predict_and_fuse_gps");

// The controllers.

EstimatorState hovering() {
  EstimatorState state;
  state.p_N = {0.1, -0.1, -2.4};
  state.v_N = {0.05, 0.02, 0};
  return state;
}

/// Position, altitude, attitude, rates and mixer: the whole of [HILS] Fig. 8.
void controllers_and_mixer(benchmark::State& state) {
  ControlCascade cascade(iris());
  cascade.set_params({});
  ControlSetpoint setpoint;
  setpoint.trajectory = TrajectorySetpoint{};
  setpoint.trajectory->p_N = {0, 0, -2.5};
  setpoint.trajectory->yaw_rad = 0;
  const EstimatorState estimate = hovering();
  for (auto _ : state) benchmark::DoNotOptimize(cascade.update(setpoint, estimate, 0.0025));
}
BENCHMARK(controllers_and_mixer);

/// Attitude, rates and mixer only.
void attitude_and_mixer(benchmark::State& state) {
  ControlCascade cascade(iris());
  cascade.set_params({});
  ControlSetpoint setpoint;
  setpoint.attitude = AttitudeSetpoint{};
  setpoint.attitude->thrust_n = 15;
  const EstimatorState estimate = hovering();
  for (auto _ : state) benchmark::DoNotOptimize(cascade.update(setpoint, estimate, 0.0025));
}
BENCHMARK(attitude_and_mixer);

void mixer(benchmark::State& state) {
  const Mixer mixer(iris());
  const Eigen::Vector4d demand(15, 0.3, -0.2, 0.05);
  for (auto _ : state) benchmark::DoNotOptimize(mixer.mix(demand));
}
BENCHMARK(mixer);

/// The allocation for any rotors, within the limits and far beyond them.
void allocation(benchmark::State& state, const base::Vehicle& vehicle, double size) {
  const ControlAllocation allocation(AllocationSetup::of(vehicle));
  ControlDemand demand;
  demand.u << vehicle.mass_kg * 9.80665, 0.3 * size, -0.2 * size, 0.05 * size;
  for (auto _ : state) benchmark::DoNotOptimize(allocation.allocate(demand));
}
BENCHMARK_CAPTURE(allocation, quad, iris(), 1);
BENCHMARK_CAPTURE(allocation, quad_saturated, iris(), 30);
BENCHMARK_CAPTURE(allocation, hexa, fcu::test::hexa_x(), 1);
BENCHMARK_CAPTURE(allocation, hexa_saturated, fcu::test::hexa_x(), 30);
BENCHMARK_CAPTURE(allocation, octo, fcu::test::octo_x(), 1);
BENCHMARK_CAPTURE(allocation, tilted_hexa, fcu::test::tilted_hexa(0.35), 1);

// All of it.

struct Recording {
  FcuConfig config;
  std::vector<std::pair<base::RunTime, std::vector<std::uint8_t>>> packets;
};

/// Take-off and 30 s of hover at Table 1 noise: everything the controller was given.
const Recording& recording() {
  static const Recording flown = [] {
    Recording out;
    fcu::test::LoopOptions options;
    options.tap = [&out](std::span<const std::uint8_t> bytes, base::RunTime now) {
      out.packets.emplace_back(now, std::vector(bytes.begin(), bytes.end()));
    };
    fcu::test::ClosedLoop loop(options);
    loop.fly_to_hover(2.5);
    loop.keep_packets = false;
    loop.run(30);
    out.config = loop.config();
    return out;
  }();
  return flown;
}

/// One HIL_SENSOR from its bytes to the bytes of the answer, telemetry that falls due included.
void update_in_flight(benchmark::State& state) {
  const Recording& flight = recording();
  base::Histogram all;
  for (auto _ : state) {
    std::uint64_t answers = 0;
    FlightController controller(flight.config, [&answers](auto) { ++answers; });
    base::Duration sum{};
    for (const auto& [time, bytes] : flight.packets) {
      const base::RunTime begin = base::steady_now();
      controller.on_bytes(bytes, time);
      const base::Duration took = base::steady_now() - begin;
      if (mav::view_packet(bytes).message_id != mavlink::common::HilSensor::kId) continue;
      all.add(took);
      sum += took;
    }
    benchmark::DoNotOptimize(answers);
    state.SetIterationTime(base::to_seconds(sum));
  }
  state.counters["p50_us"] = 1e6 * base::to_seconds(all.quantile(0.5));
  state.counters["p99_us"] = 1e6 * base::to_seconds(all.quantile(0.99));
  state.counters["bound_us"] = 20;
}
BENCHMARK(update_in_flight)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();

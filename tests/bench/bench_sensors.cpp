// SPDX-License-Identifier: BSD-3-Clause
// Cost of one sample of each sensor, of the rotors' derivatives and of one HIL_SENSOR.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "base/config/vehicle.hpp"
#include "plugins/barometer/barometer_model.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/external_ahrs/vector_nav.hpp"
#include "plugins/gps/gps_model.hpp"
#include "plugins/imu/imu_model.hpp"
#include "plugins/magnetometer/magnetometer_model.hpp"
#include "plugins/mavlink_interface/hil_interface.hpp"
#include "plugins/motor/motor_mixer.hpp"
#include "plugins/motor/rotor_model.hpp"
#include "plugins/rangefinder/rangefinder_model.hpp"
#include "plugins/wind/wind_model.hpp"
#include "tests/plugins/vector_nav_driver.hpp"
#include "tests/support/paths.hpp"

namespace cas::sim {
namespace {

const base::Geodetic kHome{47.397742, 8.545594, 488.0};
constexpr double kStep = 1e-3;

base::ConfigNode preset(const char* sensor) {
  const std::string file = cas::test::source_dir() + "/config/sensors/pixhawk.yaml";
  return base::ConfigNode::load(file).at(sensor);
}

base::Vehicle iris() {
  return base::Vehicle::load(std::filesystem::path(cas::test::source_dir()) /
                             "config/vehicles/iris_px4.yaml");
}

BodyState moving() {
  BodyState state;
  state.v_WB = {1, 2, 0.5};
  state.w_WB_B = {0.1, 0.2, 0.3};
  state.q_WB = Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized());
  return state;
}

void ImuStep(benchmark::State& bench) {  // what it costs in a step without a sample
  ImuModel imu(parse_imu_params(preset("imu"), kStep), 1);
  const BodyState state = moving();
  for (auto _ : bench) {
    imu.accumulate(state, {0, 0, -9.8}, kStep);
    imu.advance_vibration(Eigen::Vector4d(800, 810, 790, 805), kStep);
    benchmark::DoNotOptimize(imu);
  }
}
BENCHMARK(ImuStep);

void ImuSample(benchmark::State& bench) {
  ImuModel imu(parse_imu_params(preset("imu"), kStep), 1);
  const BodyState state = moving();
  for (auto _ : bench) benchmark::DoNotOptimize(imu.sample({}, state));
}
BENCHMARK(ImuSample);

void GpsSample(benchmark::State& bench) {
  GpsModel gps(read_at_rate<base::read_gps_sheet>(preset("gps"), kStep),
               base::LocalProjection(kHome), 1);
  const base::SimTime after_first_fix(std::chrono::seconds(10));
  for (auto _ : bench) {
    benchmark::DoNotOptimize(gps.sample(after_first_fix, {10, 20, -3}, {1, 2, 0}));
  }
}
BENCHMARK(GpsSample);

void MagnetometerSample(benchmark::State& bench) {
  MagnetometerModel magnetometer(
      read_at_rate<base::read_magnetometer_sheet>(preset("magnetometer"), kStep),
      base::LocalProjection(kHome), 2026.5, 1);
  const BodyState state = moving();
  for (auto _ : bench) benchmark::DoNotOptimize(magnetometer.sample({}, state));
}
BENCHMARK(MagnetometerSample);

void BarometerSample(benchmark::State& bench) {
  BarometerModel barometer(read_at_rate<base::read_barometer_sheet>(preset("barometer"), kStep), 1);
  for (auto _ : bench) benchmark::DoNotOptimize(barometer.sample({}, 490, 3, 1.17));
}
BENCHMARK(BarometerSample);

void RangeSample(benchmark::State& bench) {
  RangefinderModel rangefinder(
      read_at_rate<base::read_rangefinder_sheet>(preset("rangefinder"), kStep), 1);
  for (auto _ : bench) benchmark::DoNotOptimize(rangefinder.sample({}, 2.5));
}
BENCHMARK(RangeSample);

void WindStep(benchmark::State& bench) {
  const auto node =
      base::ConfigNode::parse("{mean_m_s: 5, from_deg: 270, profile: log, turbulence: moderate}");
  WindModel wind(parse_wind_params(node), 1);
  double v = 0;
  for (auto _ : bench) {
    v = 1 - v;  // another airspeed, another filter
    benchmark::DoNotOptimize(wind.advance_N({}, kStep, 10, {v, 0, 0}));
  }
}
BENCHMARK(WindStep);

void rotor_derivatives(benchmark::State& bench, const base::Vehicle& vehicle) {
  RotorModel rotors(vehicle);
  rotors.set_targets(Eigen::Vector4d::Constant(805));
  const BodyState state = moving();
  Environment air;
  air.air_density_kg_m3 = 1.17;
  air.height_above_ground_m = 2;
  const std::array<double, 4> omega{800, 801, 802, 803};
  std::array<double, 4> omega_dot{};
  for (auto _ : bench) {
    Wrench wrench;
    rotors.evaluate(state, air, omega, omega_dot, wrench);
    benchmark::DoNotOptimize(wrench);
  }
}

void RotorDerivatives(benchmark::State& bench) {  // four of them per RK4 step
  rotor_derivatives(bench, iris());
}
BENCHMARK(RotorDerivatives);

void RotorDerivativesWithInflow(benchmark::State& bench) {
  base::Vehicle vehicle = iris();
  for (base::Rotor& rotor : vehicle.rotors) {
    rotor.params.zero_thrust_speed_m_s = 0;
    rotor.params.inflow_thrust_slope = 0.7;
  }
  rotor_derivatives(bench, vehicle);
}
BENCHMARK(RotorDerivativesWithInflow);

void MixControls(benchmark::State& bench) {
  const MotorMixer mixer(iris());
  MotorCommand command;
  command.armed = true;
  command.values = Eigen::Vector4d(15, 0.1, 0.1, 0.01);
  for (auto _ : bench) benchmark::DoNotOptimize(mixer.targets(command));
}
BENCHMARK(MixControls);

/// Takes packets and forgets them.
class NullPort final : public HilPort {
 public:
  bool send(std::span<const std::uint8_t> packet) override {
    benchmark::DoNotOptimize(packet.data());
    return true;
  }
  void poll(const OnBytes&) override {}
  bool wait(base::Duration) override { return false; }
  base::RunTime now() const override { return {}; }
  std::string endpoint() const override { return "null"; }
};

void PackHilSensor(benchmark::State& bench) {
  NullPort port;
  HilInterface interface({}, port, nullptr);
  cas::sim::ImuSample sample;
  sample.specific_force_B = {0.1, 0.2, 9.8};
  for (auto _ : bench) {
    sample.time += std::chrono::milliseconds(2);
    interface.on_imu(sample);
    interface.flush(sample.time);
  }
}
BENCHMARK(PackHilSensor);

/// A packet of the unit that ArduCopter 4.6.2 asks for, with the steps between two.
void ExternalAhrsPacket(benchmark::State& bench) {
  VectorNav unit(UnitModel::kVn200, 921'600);
  for (const char* line : {"VNWRG,75,3,2,01,0721", "VNWRG,76,3,16,31,0001,0106,0613",
                           "VNWRG,77,3,160,49,0003,26B8,0018", "VNASY,1"}) {
    const std::string text = test::nmea_line(line);
    unit.receive({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  unit.take_answers({});
  const UnitReadings readings;
  base::SimTime now{};
  std::int64_t packets = 0;
  for (auto _ : bench) {
    for (bool sent = false; !sent;) {
      now += std::chrono::microseconds(1250);
      unit.advance(now);
      FreshSamples fresh{.inertial = true, .fix = true};
      for (; !unit.next(now, readings, fresh).empty(); ++packets) sent = true;
    }
  }
  bench.SetItemsProcessed(packets);
}
BENCHMARK(ExternalAhrsPacket);

}  // namespace
}  // namespace cas::sim

BENCHMARK_MAIN();

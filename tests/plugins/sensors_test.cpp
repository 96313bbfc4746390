// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "plugins/barometer/barometer_model.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/gps/gps_model.hpp"
#include "plugins/magnetometer/magnetometer_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::kHome;
using test::Statistics;

constexpr const char* kGps =
    "{rate_hz: 5, position_stddev_m: 0.3, velocity_stddev_m_s: 0.1, eph_m: 0.42, epv_m: 0.3, "
    "satellites: 10, delay_s: 0.12}";

base::GpsSheet quiet_gps() {
  base::GpsSheet params;
  params.rate_hz = 5;
  params.position.stddev = params.velocity.stddev = Vector3d::Constant(1e-9);
  params.satellites = 12;
  params.eph_m = 0.9;
  params.epv_m = 1.2;
  return params;
}

TEST(Gps, PlaceIsEquation5) {
  GpsModel gps(quiet_gps(), base::LocalProjection(kHome), 1);
  const double north = 300;
  const double east = -400;
  const GpsSample sample = gps.sample(base::SimTime{}, {north, east, -2.5}, {1, 2, 3});
  // [HILS] Eq. (5) as printed: c = rho / R.
  constexpr double kRadius = 6371000;
  const double rho = std::hypot(north, east);
  const double c = rho / kRadius;
  const double lat0 = kHome.lat_deg * M_PI / 180;
  const double lat =
      std::asin(std::cos(c) * std::sin(lat0) + north / rho * std::sin(c) * std::cos(lat0));
  const double lon =
      kHome.lon_deg * M_PI / 180 +
      std::atan(east * std::sin(c) /
                (rho * std::cos(c) * std::cos(lat0) - north * std::sin(c) * std::sin(lat0)));
  EXPECT_NEAR(sample.position.lat_deg, lat * 180 / M_PI, 1e-10);
  EXPECT_NEAR(sample.position.lon_deg, lon * 180 / M_PI, 1e-10);
  EXPECT_NEAR(sample.position.alt_m, 490.5, 1e-6);
  EXPECT_TRUE(sample.velocity_N.isApprox(Vector3d(1, 2, 3), 1e-7));
  EXPECT_EQ(sample.fix_type, 3);
  EXPECT_EQ(sample.satellites, 12);
}

TEST(Gps, WhiteNoiseHasTheConfiguredDeviationInMetres) {
  const auto params = read_at_rate<base::read_gps_sheet>(base::ConfigNode::parse(kGps), 1e-3);
  const base::LocalProjection projection(kHome);
  GpsModel gps(params, projection, 3);
  std::array<Statistics, 6> axes;
  for (int i = 0; i < 40000; ++i) {
    const GpsSample sample = gps.sample(base::SimTime{}, Vector3d::Zero(), Vector3d::Zero());
    const Vector3d p_N = projection.to_local(sample.position);
    for (int axis = 0; axis < 3; ++axis) {
      axes[static_cast<std::size_t>(axis)].add(p_N[axis]);
      axes[static_cast<std::size_t>(axis + 3)].add(sample.velocity_N[axis]);
    }
  }
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(axes[i].stddev(), i < 3 ? 0.3 : 0.1, i < 3 ? 0.005 : 0.002);
  }
}

TEST(Gps, HasNoFixBeforeTheFirstAndDuringLosses) {
  base::GpsSheet params = quiet_gps();
  params.first_fix_s = 2;
  params.fix_losses = {{10, 12}};
  GpsModel gps(params, base::LocalProjection(kHome), 1);
  const auto at = [&gps](double s) {
    return gps.sample(base::SimTime(base::from_seconds(s)), Vector3d::Zero(), Vector3d::Zero());
  };
  EXPECT_EQ(at(1.8).fix_type, 1);
  EXPECT_EQ(at(1.8).satellites, 0);
  EXPECT_EQ(at(2.0).fix_type, 3);
  EXPECT_EQ(at(10.0).fix_type, 1);
  EXPECT_EQ(at(12.0).fix_type, 3);
}

TEST(Gps, DriftStandsAtItsDeviationWhateverTheRate) {
  for (const double rate : {1.0, 5.0, 10.0}) {
    base::GpsSheet params = quiet_gps();
    params.rate_hz = rate;
    params.position_drift.stddev = Vector3d::Constant(0.8);
    params.position_drift.time_constant_s = 60;
    const base::LocalProjection projection(kHome);
    GpsModel gps(params, projection, 5);
    Statistics north;
    for (int i = 0; i < static_cast<int>(200000 * rate); i += 1) {
      north.add(
          projection.to_local(gps.sample({}, Vector3d::Zero(), Vector3d::Zero()).position).x());
    }
    EXPECT_NEAR(north.stddev(), 0.8, 0.08) << rate;  // 3333 time constants: 2.5 standard errors
  }
}

TEST(GpsPlugin, IsExactInCountAndDelay) {
  test::PluginHarness harness;
  harness.add("gps", kGps);
  std::vector<std::pair<base::SimTime, base::SimTime>> stamps;  // measured, published
  base::SimTime now;
  const auto listening = harness.bus.subscribe<GpsSample>(
      "iris0/gps", [&](const GpsSample& sample) { stamps.emplace_back(sample.time, now); });
  for (int i = 1; i <= 2120; ++i) {
    now = base::SimTime(std::chrono::milliseconds(i));
    harness.step();
  }
  ASSERT_EQ(stamps.size(), 10U);
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_EQ(stamps[i].first.time_since_epoch(), std::chrono::milliseconds(200 * (i + 1)));
    EXPECT_EQ(stamps[i].second - stamps[i].first, std::chrono::milliseconds(120));
  }
}

TEST(GpsPlugin, AntennaOnALeverMovesWithTheBodysTurn) {
  test::PluginHarness harness;
  harness.add("gps",
              "{rate_hz: 5, position_stddev_m: 1.0e-6, velocity_stddev_m_s: 1.0e-6, eph_m: 1, "
              "epv_m: 1, satellites: 9, antenna_B_m: [0.5, 0, 0]}");
  harness.world.body.w_WB_B = {0, 0, 2};  // nose east, turning to the left: antenna moves north
  Vector3d velocity_N = Vector3d::Zero();
  const auto listening = harness.bus.subscribe<GpsSample>(
      "iris0/gps", [&](const GpsSample& sample) { velocity_N = sample.velocity_N; });
  harness.run(std::chrono::milliseconds(200));
  EXPECT_TRUE(velocity_N.isApprox(Vector3d(1, 0, 0), 1e-4));
}

base::MagnetometerSheet quiet_magnetometer() {
  base::MagnetometerSheet params;
  params.rate_hz = 100;
  params.noise.stddev = Vector3d::Constant(1e-12);
  return params;
}

TEST(Magnetometer, ReadsTheWorldModelInTheBodysAxes) {
  MagnetometerModel magnetometer(quiet_magnetometer(), base::LocalProjection(kHome), 2026.5, 1);
  const Vector3d field_N = base::magnetic_field_N(kHome, 2026.5);
  EXPECT_NEAR(field_N.norm(), 0.48, 0.01);  // Zurich

  BodyState nose_north;
  nose_north.q_WB = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  const Vector3d field_D = base::swap_BD(magnetometer.sample({}, nose_north).field_B_gauss);
  EXPECT_TRUE(field_D.isApprox(field_N, 1e-9));

  BodyState nose_east;
  const Vector3d east_D = base::swap_BD(magnetometer.sample({}, nose_east).field_B_gauss);
  EXPECT_TRUE(east_D.isApprox(Vector3d(field_N.y(), -field_N.x(), field_N.z()), 1e-9));
}

TEST(Magnetometer, IronBendsAndShiftsTheField) {
  base::MagnetometerSheet params = quiet_magnetometer();
  params.hard_iron_gauss = {0.1, -0.2, 0.3};
  params.soft_iron << 1.1, 0.02, 0, 0.02, 0.9, 0, 0, 0, 1;
  MagnetometerModel plain(quiet_magnetometer(), base::LocalProjection(kHome), 2026.5, 1);
  MagnetometerModel bent(params, base::LocalProjection(kHome), 2026.5, 1);
  const Vector3d truth_B = plain.sample({}, {}).field_B_gauss;
  EXPECT_TRUE(bent.sample({}, {}).field_B_gauss.isApprox(
      params.soft_iron * truth_B + params.hard_iron_gauss, 1e-9));
}

TEST(Magnetometer, FollowsAVehicleThatTravels) {
  MagnetometerModel magnetometer(quiet_magnetometer(), base::LocalProjection(kHome), 2026.5, 1);
  BodyState far{.p_WB = {0, 200000, 0}};
  far.q_WB = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  const base::Geodetic place = base::LocalProjection(kHome).to_geodetic({200000, 0, 0});
  EXPECT_TRUE(base::swap_BD(magnetometer.sample({}, far).field_B_gauss)
                  .isApprox(base::magnetic_field_N(place, 2026.5), 1e-9));
}

TEST(Magnetometer, ReadsTheWorldsOwnFieldWhereItHasOne) {
  MagnetometerModel magnetometer(quiet_magnetometer(), base::LocalProjection(kHome), 2026.5, 1);
  const Vector3d own_W{0.06, 0.23, -0.42};
  BodyState far;  // wherever it is: the same everywhere
  far.p_WB = {0, 200000, 0};
  EXPECT_TRUE(magnetometer.sample({}, far, own_W).field_B_gauss.isApprox(own_W, 1e-9));
  BodyState turned;
  turned.q_WB = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());  // x of B points along y of W
  EXPECT_TRUE(magnetometer.sample({}, turned, own_W)
                  .field_B_gauss.isApprox(Vector3d(0.23, -0.06, -0.42), 1e-9));
}

base::BarometerSheet quiet_barometer() {
  base::BarometerSheet params;
  params.rate_hz = 50;
  params.noise.stddev = Vector3d::Constant(1e-9);
  return params;
}

TEST(Barometer, ReadsTheStandardAtmosphere) {
  BarometerModel barometer(quiet_barometer(), 1);
  const BarometerSample at_home = barometer.sample({}, 488, 0, 1.17);
  EXPECT_NEAR(at_home.pressure_pa, 95600, 15);  // 956.0 hPa
  EXPECT_NEAR(at_home.temperature_degc, 11.83, 0.01);
  const double per_metre = barometer.sample({}, 489, 0, 1.17).pressure_pa - at_home.pressure_pa;
  EXPECT_NEAR(per_metre, -11.46, 0.01);
}

TEST(Barometer, KnowsTheSensorsHeatAndTheWind) {
  base::BarometerSheet params = quiet_barometer();
  params.self_heating_degc = 20;
  params.wind_pressure_coefficient = -0.5;
  BarometerModel barometer(params, 1);
  const BarometerSample sample = barometer.sample({}, 0, 10, 1.2);
  EXPECT_NEAR(sample.pressure_pa, 101325 - 0.5 * 60, 1e-6);
  EXPECT_NEAR(sample.temperature_degc, 35, 1e-9);
}

TEST(Barometer, ReadsTheWorldsOwnAir) {
  BarometerModel barometer(quiet_barometer(), 1);
  const base::Atmosphere hot{
      .temperature_K = 310, .temperature_gradient_K_m = -0.0098, .pressure_Pa = 99'000};
  const BarometerSample sample = barometer.sample({}, 1000, 0, 1.2, hot);
  // 99 000 Pa (300.2 K / 310 K)^(9.80665 / (287.053 * 0.0098))
  EXPECT_NEAR(sample.pressure_pa, 99'000 * std::pow(300.2 / 310, 9.80665 / (287.053 * 0.0098)),
              0.1);
  EXPECT_NEAR(sample.temperature_degc, 300.2 - 273.15, 1e-9);
}

TEST(Barometer, RoundsToItsResolution) {
  base::BarometerSheet params;
  params.rate_hz = 50;
  params.noise.stddev = Vector3d::Constant(3);
  params.lsb_pa = 4;
  BarometerModel barometer(params, 1);
  for (int i = 0; i < 100; ++i) {
    const double steps = barometer.sample({}, 488, 0, 1.2).pressure_pa / 4;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
  }
}

TEST(Barometer, NoiseHasNoMeanAndTheConfiguredDeviation) {
  base::BarometerSheet params = quiet_barometer();
  params.noise.stddev = Vector3d::Constant(1.0);
  BarometerModel barometer(params, 11);
  Statistics error;
  const double truth = base::isa::pressure_pa(488);
  for (int i = 0; i < 200000; ++i) {
    error.add(barometer.sample({}, 488, 0, 1.2).pressure_pa - truth);
  }
  EXPECT_NEAR(error.mean(), 0, 0.01);  // 4 standard errors
  EXPECT_NEAR(error.stddev(), 1, 0.01);
}

TEST(SlowSensors, AreExactInCount) {
  test::PluginHarness harness{std::chrono::milliseconds(4)};
  harness.add("magnetometer", "{rate_hz: 100, stddev_gauss: 0.004}");
  harness.add("barometer", "{rate_hz: 50, stddev_pa: 1}");
  int fields = 0;
  int pressures = 0;
  const auto magnetometer = harness.bus.subscribe<MagnetometerSample>(
      "iris0/magnetometer", [&](const MagnetometerSample&) { ++fields; });
  const auto barometer = harness.bus.subscribe<BarometerSample>(
      "iris0/barometer", [&](const BarometerSample&) { ++pressures; });
  harness.run(std::chrono::seconds(10));
  EXPECT_EQ(fields, 1000);
  EXPECT_EQ(pressures, 500);
}

}  // namespace
}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <string>
#include <utility>
#include <vector>

#include "plugins/wind/dryden.hpp"
#include "plugins/wind/wind_grid.hpp"
#include "plugins/wind/wind_model.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using test::Statistics;

constexpr double kKnot = 0.514444;

TEST(DrydenScales, AreThoseOfTheSpecification) {
  // MIL-F-8785C at h = 100 ft, W20 = 30 kt: L_u = 100 / (0.2593)^1.2 ft, sigma_w = 3 kt.
  const DrydenScales scales = DrydenScales::at(30 * kKnot, 30.48);
  EXPECT_NEAR(scales.length_vertical_m, 30.48, 1e-9);
  EXPECT_NEAR(scales.length_horizontal_m, 100 / std::pow(0.2593, 1.2) * 0.3048, 1e-9);
  EXPECT_NEAR(scales.sigma_vertical_m_s, 3 * kKnot, 1e-9);
  EXPECT_NEAR(scales.sigma_horizontal_m_s, 3 * kKnot / std::pow(0.2593, 0.4), 1e-9);
}

TEST(DrydenScales, AreHeldBelowTenFeet) {
  EXPECT_EQ(DrydenScales::at(10, 0).length_vertical_m,
            DrydenScales::at(10, 3.048).length_vertical_m);
}

TEST(DrydenScales, AreThoseOfFigure7FromTwoThousandFeetOn) {
  constexpr double kFoot = 0.3048;
  const auto sigma_ft_s = [](double w20_kt, double height_ft) {
    const DrydenScales scales = DrydenScales::at(w20_kt * kKnot, height_ft * kFoot);
    EXPECT_NEAR(scales.length_horizontal_m, 1750 * kFoot, 1e-9);
    EXPECT_NEAR(scales.length_vertical_m, 1750 * kFoot, 1e-9);
    EXPECT_NEAR(scales.sigma_horizontal_m_s, scales.sigma_vertical_m_s, 1e-9);
    return scales.sigma_vertical_m_s / kFoot;
  };
  EXPECT_NEAR(sigma_ft_s(15, 7500), 6.7, 1e-9);
  EXPECT_NEAR(sigma_ft_s(30, 3750), 10.6, 1e-9);
  EXPECT_NEAR(sigma_ft_s(45, 80000), 5.1, 1e-9);
  EXPECT_NEAR(sigma_ft_s(45, 90000), 5.1, 1e-9) << "as at the end of the figure";
  EXPECT_NEAR(sigma_ft_s(30, 5625), (10.6 + 10.1) / 2, 1e-9) << "between heights";
  EXPECT_NEAR(sigma_ft_s(37.5, 7500), (10.1 + 23.6) / 2, 1e-9) << "between curves";
  EXPECT_NEAR(sigma_ft_s(60, 7500), 23.6 + (23.6 - 10.1), 1e-9);
  EXPECT_NEAR(sigma_ft_s(7.5, 7500), 6.7 / 2, 1e-9);
}

TEST(DrydenScales, GoLinearlyFromOneThousandToTwoThousandFeet) {
  constexpr double kFoot = 0.3048;
  const DrydenScales low = DrydenScales::at(10, 1000 * kFoot);
  const DrydenScales middle = DrydenScales::at(10, 1500 * kFoot);
  const DrydenScales high = DrydenScales::at(10, 2000 * kFoot);
  EXPECT_NEAR(low.length_vertical_m, 1000 * kFoot, 1e-9);
  for (const auto member :
       {&DrydenScales::length_horizontal_m, &DrydenScales::length_vertical_m,
        &DrydenScales::sigma_horizontal_m_s, &DrydenScales::sigma_vertical_m_s}) {
    EXPECT_NEAR(middle.*member, (low.*member + high.*member) / 2, 1e-9);
    EXPECT_NEAR(DrydenScales::at(10, 1000.001 * kFoot).*member, low.*member, 1e-3) << "no jump";
  }
}

constexpr DrydenScales kScales{.length_horizontal_m = 40,
                               .length_vertical_m = 10,
                               .sigma_horizontal_m_s = 2,
                               .sigma_vertical_m_s = 1};
constexpr double kSpeed = 8;

TEST(Dryden, HasItsIntensitiesAtAnyStep) {
  for (const double dt : {0.001, 0.004, 0.1, 1.0}) {
    Dryden dryden(17);
    Statistics u, v, w;
    const int count = static_cast<int>(std::min(2e6, 40'000 / dt));
    for (int i = 0; i < count; ++i) {
      const Vector3d gust = dryden.advance(kScales, kSpeed, dt);
      u.add(gust[0]);
      v.add(gust[1]);
      w.add(gust[2]);
    }
    // Time constants 5 s and 1.25 s: at least 2000 s are 200 independent values.
    const double limit = 4.0 / std::sqrt(2.0 * count * dt / 10.0);
    EXPECT_NEAR(u.stddev() / 2, 1, limit) << dt;
    EXPECT_NEAR(v.stddev() / 2, 1, limit) << dt;
    EXPECT_NEAR(w.stddev() / 1, 1, limit) << dt;
  }
}

/// One-sided power spectral density at one frequency, averaged over Hann-windowed stretches.
double density_at(const std::vector<double>& samples, double dt, double omega) {
  constexpr std::size_t kLength = 8192;
  double sum = 0;
  int stretches = 0;
  double window_power = 0;
  for (std::size_t i = 0; i < kLength; ++i) {
    window_power += std::pow(std::sin(M_PI * static_cast<double>(i) / kLength), 4);
  }
  for (std::size_t start = 0; start + kLength <= samples.size(); start += kLength / 2) {
    std::complex<double> line = 0;
    const std::complex<double> turn = std::polar(1.0, -omega * dt);
    std::complex<double> phase = 1;
    for (std::size_t i = 0; i < kLength; ++i) {
      const double window = std::pow(std::sin(M_PI * static_cast<double>(i) / kLength), 2);
      line += samples[start + i] * window * phase;
      phase *= turn;
    }
    sum += std::norm(line);
    ++stretches;
  }
  return sum / stretches * dt / window_power / M_PI;  // per rad/s, one-sided
}

TEST(Dryden, HasTheSpectraOfTheSpecification) {
  constexpr double kStep = 0.02;
  Dryden dryden(23);
  std::vector<double> u, v, w;
  for (int i = 0; i < 1'000'000; ++i) {
    const Vector3d gust = dryden.advance(kScales, kSpeed, kStep);
    u.push_back(gust[0]);
    v.push_back(gust[1]);
    w.push_back(gust[2]);
  }
  const double tau = kScales.length_horizontal_m / kSpeed;
  const double tau_w = kScales.length_vertical_m / kSpeed;
  const auto longitudinal = [](double sigma, double t, double omega) {
    return sigma * sigma * 2 * t / M_PI / (1 + std::pow(t * omega, 2));
  };
  const auto lateral = [](double sigma, double t, double omega) {
    const double x = std::pow(t * omega, 2);
    return sigma * sigma * t / M_PI * (1 + 3 * x) / std::pow(1 + x, 2);
  };
  constexpr double kLimit = 0.2;  // 4 standard errors of 243 half-overlapping stretches, rounded up
  for (const double omega : {0.1, 0.3, 1.0, 3.0, 10.0}) {
    EXPECT_NEAR(density_at(u, kStep, omega) / longitudinal(2, tau, omega), 1, kLimit) << omega;
    EXPECT_NEAR(density_at(v, kStep, omega) / lateral(2, tau, omega), 1, kLimit) << omega;
    EXPECT_NEAR(density_at(w, kStep, omega) / lateral(1, tau_w, omega), 1, kLimit) << omega;
  }
}

TEST(DrydenRates, HaveTheSpectraOfTheSpecification) {
  constexpr double kSpan = 0.6;
  constexpr double kStep = 0.01;
  Dryden dryden(5);
  DrydenRates rates(kSpan, 6);
  std::vector<double> along_v, along_w, across_w;
  double others = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    Eigen::Matrix3d gradient =
        rates.advance(kScales, kSpeed, kStep, dryden.advance(kScales, kSpeed, kStep));
    along_v.push_back(std::exchange(gradient(1, 0), 0));
    along_w.push_back(std::exchange(gradient(2, 0), 0));
    across_w.push_back(std::exchange(gradient(2, 1), 0));
    others += gradient.cwiseAbs().sum();
  }
  EXPECT_EQ(others, 0);
  const double lag_v = 3 * kSpan / (M_PI * kSpeed);
  const double lag_w = 4 * kSpan / (M_PI * kSpeed);
  const auto along = [](double sigma, double length, double lag, double omega) {
    const double x = std::pow(length / kSpeed * omega, 2);
    const double gust = sigma * sigma * length / kSpeed / M_PI * (1 + 3 * x) / std::pow(1 + x, 2);
    return gust * std::pow(omega / kSpeed, 2) / (1 + std::pow(lag * omega, 2));
  };
  const double length = kScales.length_vertical_m;
  constexpr double kLimit = 0.2;  // as above
  for (const double omega : {0.3, 1.0, 3.0, 10.0}) {
    EXPECT_NEAR(
        density_at(along_v, kStep, omega) / along(2, kScales.length_horizontal_m, lag_v, omega), 1,
        kLimit)
        << omega;
    EXPECT_NEAR(density_at(along_w, kStep, omega) / along(1, length, lag_w, omega), 1, kLimit)
        << omega;
    const double p = 0.8 * std::cbrt(M_PI * length / (4 * kSpan)) / (kSpeed * length) /
                     (1 + std::pow(lag_w * omega, 2));
    EXPECT_NEAR(density_at(across_w, kStep, omega) / p, 1, kLimit) << omega;
  }
}

WindParams parse(const std::string& yaml) {
  return parse_wind_params(base::ConfigNode::parse(yaml));
}

TEST(Wind, BlowsFromWhereItIsSaidToComeFrom) {
  WindModel wind(parse("{mean_m_s: 5, from_deg: 270}"), 1);  // a west wind moves air east
  EXPECT_TRUE(wind.advance_N({}, 1e-3, 10, Vector3d::Zero()).isApprox(Vector3d(0, 5, 0), 1e-12));
}

TEST(Wind, FollowsTheLogarithmicProfile) {
  WindModel wind(parse("{mean_m_s: 5, from_deg: 180, profile: log}"), 1);
  EXPECT_NEAR(wind.advance_N({}, 1e-3, 6.096, Vector3d::Zero()).x(), 5, 1e-9);
  const double at_2 = 5 * std::log(2 / 0.04572) / std::log(6.096 / 0.04572);
  EXPECT_NEAR(wind.advance_N({}, 1e-3, 2, Vector3d::Zero()).x(), at_2, 1e-9);
  EXPECT_NEAR(wind.advance_N({}, 1e-3, 0, Vector3d::Zero()).x(), 0, 1e-9);
}

TEST(Wind, GustRisesByOneMinusCosineHoldsAndFalls) {
  // Mean 10 m/s past a hovering vehicle: 20 m of air take 2 s.
  WindModel wind(parse("{mean_m_s: 10, from_deg: 180, gusts: [{start_s: 1, amplitude_m_s: [0, 4, "
                       "0], length_m: 20, hold_s: 3}]}"),
                 1);
  auto gust_at = [&, ms = 0](int until_ms) mutable {
    double east = 0;
    for (; ms <= until_ms; ++ms) {
      east =
          wind.advance_N(base::SimTime(std::chrono::milliseconds(ms)), 1e-3, 10, Vector3d::Zero())
              .y();
    }
    return east;
  };
  constexpr double kOneStep = 0.01;
  EXPECT_NEAR(gust_at(999), 0, 1e-12);
  EXPECT_NEAR(gust_at(2000), 2, kOneStep);
  EXPECT_NEAR(gust_at(3000), 4, kOneStep);
  EXPECT_NEAR(gust_at(5900), 4, 1e-9);
  EXPECT_NEAR(gust_at(7000), 2, 2 * kOneStep);
  EXPECT_NEAR(gust_at(8100), 0, 1e-9);
}

TEST(Wind, FollowsALawWithItsOwnReference) {
  WindModel power(
      parse("{mean_m_s: 8, from_deg: 180, profile: {law: power, reference_m: 10, exponent: 0.2}}"),
      1);
  EXPECT_NEAR(power.advance_N({}, 1e-3, 10, Vector3d::Zero()).x(), 8, 1e-9);
  EXPECT_NEAR(power.advance_N({}, 1e-3, 40, Vector3d::Zero()).x(), 8 * std::pow(4, 0.2), 1e-9);
  EXPECT_NEAR(power.advance_N({}, 1e-3, -1, Vector3d::Zero()).x(), 0, 1e-9);
  WindModel log(
      parse("{mean_m_s: 8, from_deg: 180, profile: {law: log, reference_m: 10, roughness_m: 0.1}}"),
      1);
  EXPECT_NEAR(log.advance_N({}, 1e-3, 10, Vector3d::Zero()).x(), 8, 1e-9);
  EXPECT_NEAR(log.advance_N({}, 1e-3, 1, Vector3d::Zero()).x(), 4, 1e-9);
}

TEST(Wind, AddsToTheFieldAtItsPlace) {
  WindModel wind(parse("{mean_m_s: 5, from_deg: 270}"), 1);
  EXPECT_TRUE(
      wind.advance_N({}, 1e-3, 10, Vector3d::Zero(), {1, 2, 3}).isApprox(Vector3d(1, 7, 3), 1e-12));
}

/// Turbulence along the wind and across it differ by the length of the filter alone, so the same
/// seed gives the same numbers in axes that turn with the wind.
TEST(Wind, TurbulenceHasTheAxesOfTheWindThatBlows) {
  const auto turbulence = [](const std::string& mean, const Vector3d& field_N) {
    WindModel calm(parse("{" + mean + "}"), 1);
    WindModel rough(parse("{" + mean + (mean.empty() ? "" : ", ") + "turbulence: light}"), 1);
    Vector3d difference = Vector3d::Zero();
    for (int i = 0; i < 100; ++i) {
      difference = rough.advance_N({}, 0.01, 50, Vector3d::Zero(), field_N) -
                   calm.advance_N({}, 0.01, 50, Vector3d::Zero(), field_N);
    }
    return difference;
  };
  const Vector3d south = turbulence("mean_m_s: 6, from_deg: 180", Vector3d::Zero());
  const Vector3d west = turbulence("mean_m_s: 6, from_deg: 270", Vector3d::Zero());
  EXPECT_TRUE(west.isApprox(Vector3d(-south.y(), south.x(), south.z()), 1e-9));
  // Of a grid or of the world, alone and with a mean.
  EXPECT_TRUE(turbulence("", {0, 6, 0}).isApprox(west, 1e-9));
  EXPECT_TRUE(turbulence("mean_m_s: 6, from_deg: 180", {-6, 6, 0}).isApprox(west, 1e-9));
}

/// Rises by 1 m/s per 10 m eastwards at the ground, twice as fast at 100 m; north is always 3.
constexpr const char* kGrid =
    "x_m,y_m,z_m,u_m_s,v_m_s,w_m_s\n"
    "0,0,0,0,3,0\n"
    "10,0,0,1,3,0\n"
    "0,0,100,0,3,-1\n"
    "10,0,100,2,3,-1\r\n";

TEST(WindGrid, IsLinearBetweenItsPlacesAndConstantOutside) {
  const cas::test::TemporaryFolder folder;
  const WindGrid grid = WindGrid::load(folder.write("g.csv", kGrid));
  EXPECT_TRUE(grid.at({10, 0, 0}).isApprox(Vector3d(1, 3, 0), 1e-12));
  EXPECT_TRUE(grid.at({5, 77, 0}).isApprox(Vector3d(0.5, 3, 0), 1e-12)) << "one value of y";
  EXPECT_TRUE(grid.at({5, 0, 50}).isApprox(Vector3d(0.75, 3, -0.5), 1e-12));
  EXPECT_TRUE(grid.at({-5, 0, -5}).isApprox(Vector3d(0, 3, 0), 1e-12));
  EXPECT_TRUE(grid.at({500, 0, 500}).isApprox(Vector3d(2, 3, -1), 1e-12));
  const WindGrid marked =
      WindGrid::load(folder.write("m.csv", "\xef\xbb\xbf" + std::string(kGrid)));
  EXPECT_EQ(marked.at({5, 0, 50}), grid.at({5, 0, 50})) << "with a byte order mark";
}

TEST(WindGrid, RefusesWhatIsNoGridWithItsLine) {
  const cas::test::TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    return test::refusal([&] { WindGrid::load(folder.write("g.csv", text)); });
  };
  const std::string grid = kGrid;
  const auto npos = std::string::npos;
  EXPECT_NE(refusal("x,y\n").find("g.csv:1: the first line must be x_m"), npos);
  EXPECT_NE(refusal(grid + "10,0,\n").find("g.csv:6: needs 6 numbers"), npos);
  EXPECT_NE(refusal(grid + "1,2,3,4,5,6,7\n").find("g.csv:6: needs 6 numbers"), npos);
  EXPECT_NE(refusal(grid + "5,0,0,1,1,1\n").find("5 places, and the 3 values of x"), npos);
  EXPECT_EQ(test::refusal([] { WindGrid::load("/dev/zero"); }),
            "/dev/zero: wind grid is no regular file");
  EXPECT_NE(refusal("x_m,y_m,z_m,u_m_s,v_m_s,w_m_s\n").find("has no place"), npos);
}

TEST(Wind, RefusesAWindFromNowhere) {
  EXPECT_THROW(parse("{mean_m_s: 5}"), base::ConfigError);
  EXPECT_THROW(parse("{turbulence: stormy}"), base::ConfigError);
  EXPECT_THROW(parse("{profile: {law: cubic}}"), base::ConfigError);
}

TEST(WindPlugin, MovesTheAirTheSameWayAfterReset) {
  test::PluginHarness harness;
  harness.add("wind", "{mean_m_s: 5, from_deg: 0, turbulence: moderate}");
  std::vector<Vector3d> first, second;
  for (auto* record : {&first, &second}) {
    for (int i = 0; i < 100; ++i) {
      harness.step();
      record->push_back(harness.world.air.wind_W);
    }
    harness.reset();
  }
  EXPECT_EQ(first, second);
  EXPECT_NE(first[0], first[99]);
  EXPECT_LT(first[0].y(), 0);  // a north wind moves air south
}

TEST(WindPlugin, AddsToTheWindOfTheWorldAndToAGrid) {
  const cas::test::TemporaryFolder folder;
  test::PluginHarness harness;
  harness.world.air.wind_W = {1, 0, 0};
  harness.world.body.p_WB = {10, 0, 0};
  harness.add("wind",
              "{mean_m_s: 5, from_deg: 270, grid: " + folder.write("g.csv", kGrid).string() + "}");
  for (int i = 0; i < 3; ++i) {
    harness.step();
    EXPECT_TRUE(harness.world.air.wind_W.isApprox(Vector3d(1 + 5 + 1, 3, 0), 1e-12))
        << harness.world.air.wind_W.transpose();
  }
}

TEST(WindPlugin, WithASpanGivesTheGradientOfProfileAndGrid) {
  const cas::test::TemporaryFolder folder;
  test::PluginHarness harness;
  harness.world.body.p_WB = {5, 0, 50};
  harness.world.air.height_above_ground_m = 50;
  harness.add("wind",
              "{mean_m_s: 5, from_deg: 270, profile: {law: power, reference_m: 10, "
              "exponent: 0.5}, span_m: 0.5, grid: " +
                  folder.write("g.csv", kGrid).string() + "}");
  harness.step();
  ASSERT_TRUE(harness.world.air.wind_gradient_W);
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected(0, 0) = 0.15;       // of the grid, half way up
  expected(0, 2) = 0.5 / 100;  // at x = 5 from 0.5 to 1 m/s
  expected(2, 2) = -1.0 / 100;
  expected(0, 2) += 0.5 * 5 / std::sqrt(10 * 50);  // d/dh of 5 (h / 10)^0.5
  EXPECT_TRUE(harness.world.air.wind_gradient_W->isApprox(expected, 1e-4))
      << *harness.world.air.wind_gradient_W;
}

TEST(WindPlugin, WithoutASpanLeavesTheWindAsAtTheCentre) {
  test::PluginHarness harness;
  harness.add("wind", "{mean_m_s: 5, from_deg: 0, profile: log, turbulence: moderate}");
  harness.step();
  EXPECT_FALSE(harness.world.air.wind_gradient_W);
}

TEST(Wind, ASpanDoesNotChangeTheWindAtTheCentre) {
  WindModel narrow(parse("{mean_m_s: 5, from_deg: 30, turbulence: light}"), 3);
  WindModel wide(parse("{mean_m_s: 5, from_deg: 30, turbulence: light, span_m: 0.5}"), 3);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(narrow.advance_N({}, 0.01, 20, Vector3d::Zero()),
              wide.advance_N({}, 0.01, 20, Vector3d::Zero()));
  }
  EXPECT_TRUE(narrow.gradient_N().isZero(0));
  EXPECT_FALSE(wide.gradient_N().isZero(1e-6));
}

TEST(WindPlugin, WarnsOfGustsThatItLeavesOut) {
  test::PluginHarness harness;
  const auto gusts = harness.bus.advertise<GustCommand>("iris0/gust");
  const Plugin& wind = harness.add("wind", "{}");
  const auto blow = [&gusts](int times) {
    for (int i = 0; i < times; ++i) {
      gusts.publish({.amplitude_N_m_s = {3, 0, 0}, .length_m = 2, .hold_s = 9});
    }
  };
  blow(8);
  EXPECT_EQ(wind.stats_json(), "");
  blow(2);
  EXPECT_NE(wind.stats_json().find(R"({"warnings":["plugin wind: gusts that are left out)"),
            std::string::npos);
  EXPECT_NE(wind.stats_json().find(": 2\"]}"), std::string::npos) << wind.stats_json();
  harness.reset();
  EXPECT_EQ(wind.stats_json(), "");
}

TEST(RangefinderPlugin, MeasuresAlongItsRay) {
  test::PluginHarness harness;
  harness.add("rangefinder",
              "{rate_hz: 50, stddev_m: 1.0e-6, min_m: 0.2, max_m: 20, position_B_m: [0, 0, -0.1]}");
  std::vector<RangeSample> samples;
  const auto listening = harness.bus.subscribe<RangeSample>(
      "iris0/rangefinder", [&](const RangeSample& s) { samples.push_back(s); });
  auto& body = harness.world.body;
  const auto measure = [&](double height, double roll) {
    body.p_WB.z() = height;
    body.q_WB = Eigen::AngleAxisd(roll, Vector3d::UnitX());
    samples.clear();
    harness.run(std::chrono::milliseconds(20));
    return samples.at(0);
  };
  EXPECT_NEAR(measure(5.1, 0).distance_m, 5, 1e-4);
  EXPECT_TRUE(measure(5.1, 0).valid);
  EXPECT_NEAR(measure(5.0, M_PI / 3).distance_m, 9.9, 1e-4);  // 5 / cos 60 deg less the lever
  EXPECT_FALSE(measure(0.15, 0).valid);                       // too near
  EXPECT_FALSE(measure(30, 0).valid);                         // nothing in reach
  EXPECT_EQ(measure(30, 0).max_m, 20);
}

}  // namespace
}  // namespace cas::sim

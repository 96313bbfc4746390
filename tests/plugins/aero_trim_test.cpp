// SPDX-License-Identifier: BSD-3-Clause
// Trims and eigenvalues of the Aerosonde, against those that an independent program finds with the
// same set.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <string>

#include "plugins/aero/flight_modes.hpp"
#include "plugins/aero/glide_polar.hpp"
#include "tests/plugins/aerosonde.hpp"

namespace cas::sim {
namespace {

using namespace std::complex_literals;
using Complex = std::complex<double>;

struct TrimCase {
  const char* name;
  double speed_m_s;
  double alpha_deg, elevator_rad, throttle, aileron_rad;
  double thrust_n, omega_rad_s;
  Complex short_period, phugoid, roll, dutch_roll, spiral;
};

class AerosondeTrim : public testing::TestWithParam<TrimCase> {};

/// Half of the last digit that the table has.
void expect_digits(double value, double expected, double last_digit, const std::string& what) {
  EXPECT_NEAR(value, expected, 0.501 * last_digit) << what;
}

TEST_P(AerosondeTrim, IsTheBooksToFourDigits) {
  const TrimCase& expected = GetParam();
  const Airframe airframe = test::aerosonde();
  const std::optional<Trim> trim = level_trim(airframe, expected.speed_m_s);
  ASSERT_TRUE(trim);
  EXPECT_LT(state_rates(airframe, state_of(*trim), trim->deflections_rad, trim->throttle)
                .head<6>()
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
  EXPECT_EQ(trim->beta_rad, 0);
  expect_digits(trim->alpha_rad * 180 / M_PI, expected.alpha_deg, 1e-3, "alpha");
  expect_digits(trim->deflections_rad[0], expected.aileron_rad, 1e-5, "aileron");
  expect_digits(trim->deflections_rad[1], expected.elevator_rad, 1e-5, "elevator");
  expect_digits(trim->throttle, expected.throttle, 1e-4, "throttle");
  const auto propeller = test::aerosonde_propeller(expected.speed_m_s, trim->throttle, 1.2682);
  expect_digits(propeller.thrust_n, expected.thrust_n, 1e-3, "thrust");
  expect_digits(propeller.omega_rad_s, expected.omega_rad_s, 0.1, "speed of the propeller");
}

TEST_P(AerosondeTrim, HasTheBooksModes) {
  const TrimCase& expected = GetParam();
  const Airframe airframe = test::aerosonde();
  const std::optional<Trim> trim = level_trim(airframe, expected.speed_m_s);
  ASSERT_TRUE(trim);
  const std::vector<FlightMode> modes = flight_modes(airframe, *trim);
  const std::pair<const char*, Complex> all[]{{"short period", expected.short_period},
                                              {"phugoid", expected.phugoid},
                                              {"roll", expected.roll},
                                              {"Dutch roll", expected.dutch_roll},
                                              {"spiral", expected.spiral}};
  ASSERT_EQ(modes.size(), std::size(all));
  constexpr double kFourDigits = 6e-4;  // of the value; the table has at least so many
  for (std::size_t i = 0; i < modes.size(); ++i) {
    EXPECT_EQ(modes[i].name, all[i].first);
    EXPECT_LT(std::abs(modes[i].eigenvalue - all[i].second), kFourDigits * std::abs(all[i].second))
        << modes[i].name << ' ' << modes[i].eigenvalue;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Speeds, AerosondeTrim,
    testing::Values(
        TrimCase{"At20", 20, 5.852, -0.26902, 0.6294, 0.00659, 7.618, 419.0, -3.9242 + 7.8969i,
                 -0.1136 + 0.6105i, -17.79, -1.0219 + 3.7899i, 0.1288},
        TrimCase{"At25", 25, 2.848, -0.12392, 0.7735, 0.00592, 10.330, 514.4, -4.8948 + 9.8697i,
                 -0.1426 + 0.4780i, -22.44, -1.1397 + 4.6553i, 0.0892},
        TrimCase{"At30", 30, 1.212, -0.04491, 0.9246, 0.00572, 14.195, 613.8, -5.8694 + 11.843i,
                 -0.1708 + 0.3808i, -27.06, -1.2822 + 5.5305i, 0.0676}),
    [](const auto& test) { return test.param.name; });

TEST(LevelTrim, DoesNotExistWithoutThrust) {
  Airframe glider = test::aerosonde();
  glider.wrench = [powered = glider.wrench](const BodyState& body,
                                            std::span<const double> deflections, double) {
    Wrench wrench = powered(body, deflections, 0.5);
    const auto load = test::aerosonde_propeller(body.v_WB.norm(), 0.5, 1.2682);
    wrench.force_B.x() -= load.thrust_n;
    wrench.torque_B.x() += load.torque_nm;
    return wrench;
  };
  EXPECT_FALSE(level_trim(glider, 25));
}

/// Without moments by angle of attack and rates that bind it, the slow motion of a plane keeps its
/// energy: with little drag it swings with sqrt(2) g / V (Lanchester).
TEST(Phugoid, SwingsWithLanchestersFrequency) {
  base::AeroParams aero = *test::load_plane("aerosonde").aero;
  base::DerivativeParams& body = *aero.derivatives;
  body.drag.zero = 1e-6;
  body.efficiency = 1e6;
  body.lift.q = 0;
  body.lift.surfaces.assign(3, 0.0);
  body.drag.surfaces.assign(3, 0.0);
  body.pitch.alpha = -400;  // stiff: the angle of attack does not change
  body.pitch.q = 0;
  const AeroModel model(aero);
  Airframe airframe = test::aerosonde();
  airframe.wrench = [&](const BodyState& state, std::span<const double> deflections,
                        double throttle) {
    Wrench wrench;
    std::vector<double> rates(deflections.size());
    model.evaluate(state, airframe.air, deflections, rates, wrench);
    wrench.force_B.x() += throttle;
    return wrench;
  };
  for (const double speed : {20.0, 25.0, 30.0}) {
    const std::optional<Trim> trim = level_trim(airframe, speed);
    ASSERT_TRUE(trim);
    const std::vector<FlightMode> modes = flight_modes(airframe, *trim);
    ASSERT_EQ(modes[1].name, "phugoid");
    constexpr double kStiffness = 0.02;  // what is left of the coupling with the short period
    EXPECT_NEAR(modes[1].eigenvalue.imag() / (std::sqrt(2) * 9.81 / speed), 1, kStiffness);
  }
}

}  // namespace
}  // namespace cas::sim

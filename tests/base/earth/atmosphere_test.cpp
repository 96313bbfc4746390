// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/atmosphere.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cas::base {
namespace {

constexpr double kTableRounding = 1e-4;  // ISO 2533's table prints five to six digits

struct IsaCase {
  const char* name;
  double alt_m, temperature_kelvin, pressure_pa, density_kg_m3;
};

class Isa : public testing::TestWithParam<IsaCase> {};

TEST_P(Isa, MatchesTheTableOfIso2533) {
  const IsaCase& c = GetParam();
  EXPECT_NEAR(isa::temperature_kelvin(c.alt_m), c.temperature_kelvin, 0.001);
  EXPECT_NEAR(isa::pressure_pa(c.alt_m), c.pressure_pa, c.pressure_pa * kTableRounding);
  EXPECT_NEAR(isa::density_kg_m3(c.alt_m), c.density_kg_m3, c.density_kg_m3 * kTableRounding);
}

INSTANTIATE_TEST_SUITE_P(
    GeopotentialAltitudes, Isa,
    testing::Values(IsaCase{"SeaLevel", 0, 288.150, 101325, 1.2250},
                    IsaCase{"OneKilometre", 1000, 281.650, 89874.6, 1.11164},
                    IsaCase{"FiveKilometres", 5000, 255.650, 54019.9, 0.736116},
                    IsaCase{"TenKilometres", 10000, 223.150, 26436.3, 0.412707}),
    [](const auto& test) { return test.param.name; });

TEST(IsaInverse, AltitudeOfPressureReturnsTheAltitude) {
  constexpr double kRounding = 1e-8;  // m
  for (double alt_m = -400; alt_m <= 11000; alt_m += 100) {
    EXPECT_NEAR(isa::altitude_m(isa::pressure_pa(alt_m)), alt_m, kRounding);
  }
}

TEST(IsaGradient, OneMetreAtSeaLevelIsTwelvePascals) {
  EXPECT_NEAR(isa::pressure_pa(0.5) - isa::pressure_pa(-0.5), -12.013, 0.001);
}

TEST(Atmosphere, IsTheStandardOneByDefault) {
  for (double alt_m = -400; alt_m <= 11000; alt_m += 300) {
    EXPECT_EQ(Atmosphere().temperature_kelvin(alt_m), isa::temperature_kelvin(alt_m));
    EXPECT_EQ(Atmosphere().pressure_pa(alt_m), isa::pressure_pa(alt_m));
    EXPECT_EQ(Atmosphere().density_kg_m3(alt_m), isa::density_kg_m3(alt_m));
  }
}

constexpr double kGravity = 9.80665;      // m/s^2, ISO 2533
constexpr double kGasConstant = 287.053;  // J/(kg K), dry air

/// Air of other days and places.
const Atmosphere kAirs[] = {
    {.temperature_K = 310, .temperature_gradient_K_m = -0.0098, .pressure_Pa = 99'000},  // hot, dry
    {.temperature_K = 250, .temperature_gradient_K_m = 0.01, .pressure_Pa = 104'000},  // inversion
    {.temperature_K = 280, .temperature_gradient_K_m = 0, .pressure_Pa = 101'325}};    // isothermal

TEST(Atmosphere, IsThatOfItsClosedForm) {
  const double alt_m = 1500;
  const Atmosphere& hot = kAirs[0];
  EXPECT_NEAR(hot.temperature_kelvin(alt_m), 310 - 0.0098 * 1500, 1e-9);
  EXPECT_NEAR(hot.pressure_pa(alt_m),
              99'000 * std::pow((310 - 14.7) / 310, kGravity / (kGasConstant * 0.0098)), 0.1);
  EXPECT_NEAR(kAirs[1].pressure_pa(alt_m),
              104'000 * std::pow((250 + 15.0) / 250, -kGravity / (kGasConstant * 0.01)), 0.1);
  EXPECT_NEAR(kAirs[2].pressure_pa(alt_m),
              101'325 * std::exp(-kGravity * alt_m / (kGasConstant * 280)), 0.1);
}

TEST(Atmosphere, IsAnIdealGasInHydrostaticBalance) {
  constexpr double kHalf_m = 0.5;
  for (const Atmosphere& air : kAirs) {
    for (const double alt_m : {-300.0, 0.0, 488.0, 4000.0}) {
      const double density = air.density_kg_m3(alt_m);
      EXPECT_NEAR(density, air.pressure_pa(alt_m) / (kGasConstant * air.temperature_kelvin(alt_m)),
                  1e-5);
      const double fall = air.pressure_pa(alt_m - kHalf_m) - air.pressure_pa(alt_m + kHalf_m);
      EXPECT_NEAR(fall, density * kGravity, 1e-5 * fall);
    }
  }
}

TEST(Atmosphere, HasNumbersHoweverHigh) {
  const Atmosphere steep{.temperature_gradient_K_m = -0.05};
  EXPECT_GT(steep.temperature_kelvin(50'000), 0);
  EXPECT_GE(steep.pressure_pa(50'000), 0);
  EXPECT_TRUE(std::isfinite(steep.density_kg_m3(50'000)));
}

TEST(Atmosphere, AGradientThatFadesLeadsToTheIsothermalOne) {
  const Atmosphere faint{.temperature_K = 280, .temperature_gradient_K_m = -2e-7};
  const Atmosphere none{.temperature_K = 280, .temperature_gradient_K_m = 0};
  EXPECT_NEAR(faint.pressure_pa(3000), none.pressure_pa(3000), 0.2);
}

}  // namespace
}  // namespace cas::base

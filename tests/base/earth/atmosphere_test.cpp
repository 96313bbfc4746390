// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/atmosphere.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/earth/weather.hpp"

namespace cas::base {
namespace {

constexpr double kTableRounding = 1e-4;  // ISO 2533's table prints five to six digits

TEST(Isa, MatchesTheTableOfIso2533) {
  struct IsaCase {
    const char* name;
    double alt_m, temperature_kelvin, pressure_pa, density_kg_m3;
  };
  const IsaCase rows[] = {{"SeaLevel", 0, 288.150, 101325, 1.2250},
                          {"OneKilometre", 1000, 281.650, 89874.6, 1.11164},
                          {"FiveKilometres", 5000, 255.650, 54019.9, 0.736116},
                          {"TenKilometres", 10000, 223.150, 26436.3, 0.412707},
                          {"Tropopause", 11000, 216.650, 22632.0, 0.363918},
                          {"FifteenKilometres", 15000, 216.650, 12044.6, 0.193674},
                          {"TwentyKilometres", 20000, 216.650, 5474.87, 0.0880349},
                          {"ThirtyTwoKilometres", 32000, 228.650, 868.014, 0.0132250},
                          {"FortySevenKilometres", 47000, 270.650, 110.906, 0.00142752},
                          {"FiftyOneKilometres", 51000, 270.650, 66.9384, 0.000861600},
                          {"SeventyOneKilometres", 71000, 214.650, 3.95639, 0.0000642105}};
  for (const auto& c : rows) {
    SCOPED_TRACE(c.name);
    EXPECT_NEAR(isa::temperature_kelvin(c.alt_m), c.temperature_kelvin, 0.001);
    EXPECT_NEAR(isa::pressure_pa(c.alt_m), c.pressure_pa, c.pressure_pa * kTableRounding);
    EXPECT_NEAR(isa::density_kg_m3(c.alt_m), c.density_kg_m3, c.density_kg_m3 * kTableRounding);
  }
}

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

TEST(HumidAir, SaturatesAsTheSteamTablesSay) {
  constexpr double kOfBuck = 2e-3;  // the formula's own 0.1 %, and as much for vapour without air
  struct Steam {
    double degc, pa;  // [IAPWS]
  };
  for (const auto& [degc, pa] : {Steam{0.01, 611.657}, Steam{10, 1228.2}, Steam{20, 2339.3},
                                 Steam{30, 4247.0}, Steam{40, 7384.9}}) {
    EXPECT_NEAR(saturation_pressure_pa(degc + 273.15), pa, pa * kOfBuck) << degc;
  }
}

/// [OIML R 111] Eq. (E.3-1), good to 2e-4 near the ground.
double oiml_density(double pressure_hpa, double degc, double humidity_pct) {
  return (0.34848 * pressure_hpa - 0.009 * humidity_pct * std::exp(0.061 * degc)) / (273.15 + degc);
}

TEST(HumidAir, IsAsLightAsTheFormulaOfTheWeightsSays) {
  constexpr double kIdealGas = 6e-4;  // compressibility and carbon dioxide, which are left out
  for (const double degc : {15.0, 20.0, 27.0}) {
    for (const double humidity : {0.2, 0.5, 0.8}) {
      const Atmosphere air{.temperature_K = degc + 273.15, .relative_humidity = humidity};
      const double published = oiml_density(1013.25, degc, 100 * humidity);
      EXPECT_NEAR(air.density_kg_m3(0), published, published * kIdealGas)
          << degc << ' ' << humidity;
      EXPECT_EQ(air.pressure_pa(300), Atmosphere{.temperature_K = degc + 273.15}.pressure_pa(300));
    }
  }
}

TEST(HumidAir, HasNumbersHoweverColdAndThin) {
  const Atmosphere air{.relative_humidity = 1};
  for (double alt_m = -400; alt_m < 90'000; alt_m += 500) {
    EXPECT_GT(air.density_kg_m3(alt_m), 0) << alt_m;
  }
}

constexpr double kHome_m = 488;

TEST(Weather, WithoutAWordLeavesTheAirAsItIs) {
  for (const Atmosphere& air : kAirs) EXPECT_EQ(air_of({}, air, kHome_m), air);
}

TEST(Weather, HasItsTemperatureAndPressureAtHome) {
  const Atmosphere air = air_of({.temperature_degc = 35, .qnh_hpa = 1003.25}, {}, kHome_m);
  EXPECT_NEAR(air.temperature_kelvin(kHome_m), 308.15, 1e-9);
  EXPECT_NEAR(air.temperature_kelvin(kHome_m + 1000), 301.65, 1e-9);
  // QNH is the pressure at home, reduced to sea level by the standard atmosphere.
  const double home_pa = 100'325 * isa::pressure_pa(kHome_m) / 101'325;
  EXPECT_NEAR(air.pressure_pa(kHome_m), home_pa, 1e-6);
  EXPECT_NEAR(air.density_kg_m3(kHome_m), home_pa / (287.05287 * 308.15), 1e-9);
}

TEST(Weather, OffsetCountsAtEveryAltitudeAndLeavesThePressureAtHome) {
  const Atmosphere air = air_of({.temperature_offset_degc = -20}, {}, kHome_m);
  for (const double alt_m : {0.0, kHome_m, 9000.0, 15'000.0}) {
    EXPECT_NEAR(air.temperature_kelvin(alt_m), isa::temperature_kelvin(alt_m) - 20, 1e-9) << alt_m;
  }
  EXPECT_NEAR(air.pressure_pa(kHome_m), isa::pressure_pa(kHome_m), 1e-6);
  EXPECT_LT(air.pressure_pa(3000), isa::pressure_pa(3000)) << "cold air is heavy";
}

}  // namespace
}  // namespace cas::base

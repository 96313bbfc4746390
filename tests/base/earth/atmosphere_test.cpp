// SPDX-License-Identifier: BSD-3-Clause
#include "base/earth/atmosphere.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cas::base

// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/vehicle_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "libsim/hilsim/wind_tunnel.hpp"
#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using testing::HasSubstr;

/// Torques of a vehicle of a tenth of the size are 1e-5 of the large one's.
TEST(VehicleDescription, ANanoVehicleCanBeSteeredAsALargeOneCan) {
  for (const char* name : {"quad_x", "hexa_x"}) {
    const auto file = test::kSourceDir / "config/vehicles" / (std::string(name) + ".yaml");
    for (const double s : {1.0, 0.1, 0.02}) {
      base::Vehicle vehicle = base::Vehicle::load(file);
      for (base::Rotor& rotor : vehicle.rotors) {
        rotor.position_B_m *= s;
        rotor.params.thrust_coefficient *= std::pow(s, 4);
        rotor.params.torque_coefficient *= std::pow(s, 5);
      }
      const std::string text = describe_vehicle(vehicle, load_vehicle_model(vehicle.urdf), {});
      EXPECT_THAT(text, HasSubstr("rank               4 of 6")) << name << " " << s;
      EXPECT_THAT(text, HasSubstr("yaw can be set independently")) << name << " " << s;
    }
  }
}

std::vector<std::vector<double>> polar(const base::AeroParams& aero,
                                       const std::vector<double>& alphas_deg,
                                       const std::vector<double>& betas_deg) {
  std::istringstream in(polar_csv(aero, 25, alphas_deg, betas_deg));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "alpha_deg,beta_deg,CL,CD,CY,Cl,Cm,Cn");
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    auto& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
  }
  return rows;
}

constexpr double kRounding = 1e-12;

/// The tunnel measures what [Beard]'s table has put in, of which every angle is below the stall.
TEST(WindTunnel, MeasuresTheDerivativesThatWerePutIn) {
  const base::Vehicle vehicle =
      base::Vehicle::load(test::kSourceDir / "config/vehicles/aerosonde.yaml");
  const auto rows = polar(*vehicle.aero, {-5, 0, 5, 10}, {0, 4});
  ASSERT_EQ(rows.size(), 8U);
  const double aspect = 2.8956 * 2.8956 / 0.55;
  for (const std::vector<double>& row : rows) {
    const double alpha = row[0] * M_PI / 180;
    const double slip = std::sin(row[1] * M_PI / 180);
    const double in_plane = 1 - slip * slip;  // of the dynamic pressure
    const double lift = 0.23 + 5.61 * alpha;
    constexpr double kBlend = 1e-5;  // that share is a flat plate's at 10 deg already
    EXPECT_NEAR(row[2], in_plane * lift, kBlend) << row[0];
    EXPECT_NEAR(row[3], in_plane * (0.043 + lift * lift / (M_PI * 0.9 * aspect)), kBlend);
    EXPECT_NEAR(row[4], -0.98 * slip, kRounding);
    EXPECT_NEAR(row[5], -0.13 * slip, kRounding);
    EXPECT_NEAR(row[6], in_plane * (0.0135 - 2.74 * alpha), kBlend);
    EXPECT_NEAR(row[7], 0.073 * slip, kRounding);
  }
}

/// A single panel without sweep, dihedral and incidence in clean air.
TEST(WindTunnel, MeasuresThePolarOfAPanel) {
  base::AeroParams aero;
  aero.panels.push_back({.position_B_m = {-0.1, 0, 0},
                         .area_m2 = 0.4,
                         .chord_m = 0.2,
                         .lift_slope_per_rad = 5,
                         .stall_rad = 0.3,
                         .drag_zero = 0.02,
                         .induced_drag_factor = 0.05,
                         .moment_zero = -0.03});
  for (const std::vector<double>& row : polar(aero, {-8, 0, 8}, {0})) {
    const double alpha = row[0] * M_PI / 180;
    const double lift = 5 * alpha;
    const double drag = 0.02 + 0.05 * lift * lift;
    EXPECT_NEAR(row[2], lift, kRounding);
    EXPECT_NEAR(row[3], drag, kRounding);
    // About the centre of gravity, 0.1 m in front of it; lengths of panels alone are 1 m.
    const double normal = lift * std::cos(alpha) + drag * std::sin(alpha);
    EXPECT_NEAR(row[6], 0.2 * -0.03 - 0.1 * normal, kRounding);
  }
}

TEST(WindTunnel, TakesASweepThatHasAnEnd) {
  EXPECT_THAT((AngleSweep{-1, 1, 0.5}.angles_deg("--alpha", 180)),
              testing::ElementsAre(-1, -0.5, 0, 0.5, 1));
  EXPECT_THAT((AngleSweep{3, 3, 1}.angles_deg("--alpha", 180)), testing::ElementsAre(3));
  for (const AngleSweep& wrong :
       {AngleSweep{0, 10, 0}, AngleSweep{10, 0, 1}, AngleSweep{-181, 0, 1}, AngleSweep{0, 181, 1},
        AngleSweep{0, 10, 1e-9}, AngleSweep{0, 10, std::nan("")}}) {
    EXPECT_THROW(wrong.angles_deg("--alpha", 180), base::ConfigError);
  }
}

TEST(VehicleDescription, OfAPlaneIsItsTrimStallGlideAndModes) {
  const base::Vehicle vehicle =
      base::Vehicle::load(test::kSourceDir / "config/vehicles/aerosonde.yaml");
  const std::string text = describe_vehicle(vehicle, load_vehicle_model(vehicle.urdf), {});
  for (const char* words :
       {"  elevator          -30.0   30.0 deg  output 2", "level at 25 m/s", "angle of attack",
        "throttle", "stall              ", "best glide         ", "short period", "phugoid",
        "Dutch roll", "spiral"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
  EXPECT_THAT(text, testing::Not(HasSubstr("hover")));
}

/// Servos tilt the two front rotors forwards for its trim: together they push against the drag.
TEST(VehicleDescription, OfATiltrotorHasATrimOnItsTiltedRotors) {
  const base::Vehicle vehicle =
      base::Vehicle::load(test::kSourceDir / "config/vehicles/tiltrotor.yaml");
  const std::string text = describe_vehicle(vehicle, load_vehicle_model(vehicle.urdf), {});
  for (const char* words : {"tilts from 0 to 90 deg about [0.000, 1.000, 0.000] on output 5",
                            "stands at 45 deg at output 0", "level at 15 m/s", "hover"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
  const std::string word = "  throttle ";
  const std::size_t at = text.find(word);
  ASSERT_NE(at, std::string::npos) << text;
  const double throttle = std::stod(text.substr(at + word.size()));
  const base::RotorParams& params = vehicle.rotors[0].params;
  const double thrust_n = 2 * params.thrust_coefficient *
                          std::pow(throttle * params.omega_max_rad_s, 2) * (1 - 15.0 / 25);
  EXPECT_GT(thrust_n, vehicle.mass_kg * 9.80665 / 12);
  EXPECT_LT(thrust_n, vehicle.mass_kg * 9.80665 / 4);
}

TEST(VehicleDescription, OfATailsitterHasNoTrimAlongTheNoseOfItsHover) {
  const base::Vehicle vehicle =
      base::Vehicle::load(test::kSourceDir / "config/vehicles/tailsitter.yaml");
  const std::string text = describe_vehicle(vehicle, load_vehicle_model(vehicle.urdf), {});
  EXPECT_THAT(text, HasSubstr("hover              output 0.568"));
  EXPECT_THAT(text, HasSubstr("trim               none: no panel's chord points along"));
  EXPECT_THAT(text, testing::Not(HasSubstr("stall")));
}

}  // namespace
}  // namespace cas::sim

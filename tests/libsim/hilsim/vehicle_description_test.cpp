// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/vehicle_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

TEST(VehicleDescription, OfAPlaneIsItsTrimStallGlideAndModes) {
  const base::Vehicle vehicle =
      base::Vehicle::load(test::kSourceDir / "tests/plugins/data/aerosonde.yaml");
  const std::string text = describe_vehicle(vehicle, load_vehicle_model(vehicle.urdf), {});
  for (const char* words :
       {"  elevator          -30.0   30.0 deg  output 2", "level at 25 m/s", "angle of attack",
        "throttle", "stall              ", "best glide         ", "short period", "phugoid",
        "Dutch roll", "spiral"}) {
    EXPECT_THAT(text, HasSubstr(words));
  }
  EXPECT_THAT(text, testing::Not(HasSubstr("hover")));
}

}  // namespace
}  // namespace cas::sim

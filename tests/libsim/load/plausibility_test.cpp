// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/plausibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Flown {
  base::Vehicle vehicle;
  VehicleModel model;
};

Flown load(const std::filesystem::path& file) {
  Flown flown{.vehicle = base::Vehicle::load(file), .model = {}};
  flown.model = load_vehicle_model(flown.vehicle.urdf, flown.vehicle.parts);
  return flown;
}

TEST(Plausibility, ShippedVehiclesAre) {
  for (const auto& entry :
       std::filesystem::directory_iterator(test::kSourceDir / "config/vehicles")) {
    if (entry.path().extension() != ".yaml") continue;
    const Flown flown = load(entry.path());
    EXPECT_THAT(implausible(flown.vehicle, flown.model), IsEmpty()) << entry.path();
  }
}

void set_mass(Flown& flown, double mass, double inertia_factor) {
  flown.model.mass =
      MassProperties(mass, Eigen::Matrix3d(inertia_factor * flown.model.mass.inertia_B()));
}

/// The same vehicle of another size: forces by the cube, inertias by the fifth power.
void scale(Flown& flown, double s) {
  set_mass(flown, flown.model.mass.mass_kg() * std::pow(s, 3), std::pow(s, 5));
  for (Shape& shape : flown.model.shapes) {
    std::get<Box>(shape.geometry).size_m *= s;
    shape.pose.translation() *= s;
  }
  for (base::Rotor& rotor : flown.vehicle.rotors) {
    rotor.position_B_m *= s;
    rotor.params.radius_m *= s;
    rotor.params.omega_max_rad_s /= std::sqrt(s);
    rotor.params.thrust_coefficient *= std::pow(s, 4);
    rotor.params.torque_coefficient *= std::pow(s, 5);
    rotor.params.inertia_kg_m2 *= std::pow(s, 5);
  }
}

TEST(Plausibility, GoesWithTheSize) {
  for (const double s : {0.1, 0.2, 1.0, 5.0}) {
    Flown flown = load(test::kSourceDir / "config/vehicles/quad_x.yaml");
    scale(flown, s);
    EXPECT_THAT(implausible(flown.vehicle, flown.model), IsEmpty()) << s;
  }
}

void scale_shapes(Flown& flown, double factor) {
  for (Shape& shape : flown.model.shapes) std::get<Box>(shape.geometry).size_m *= factor;
}

void each_rotor(Flown& flown, const std::function<void(base::Rotor&)>& change) {
  for (base::Rotor& rotor : flown.vehicle.rotors) change(rotor);
}

struct UnitCase {
  const char* name;
  std::function<void(Flown&)> change;
  const char* sentence;
};

// A mistake in one figure of quad_x, most of them of its unit.
TEST(WrongUnit, IsNamedOnceWithTheLikelyOne) {
  const UnitCase rows[] = {
      {"MeshInMillimetres", [](Flown& f) { scale_shapes(f, 1000); },
       "m across, of a vehicle of 1.5 kg: lengths may be in mm instead of m"},
      {"MeshInCentimetres", [](Flown& f) { scale_shapes(f, 100); }, "may be in cm"},
      {"MeshScaledTwice", [](Flown& f) { scale_shapes(f, 1e-3); }, "a mesh may be scaled twice"},
      {"ArmsInMillimetres",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.position_B_m *= 1000; }); },
       "m apart, of a vehicle of 1.5 kg: lengths may be in mm instead of m"},
      {"MassInGrams",
       [](Flown& f) {
         set_mass(f, 1500, 1000);
         each_rotor(f, [](auto& r) { r.params.thrust_coefficient *= 1000; });
       },
       "its mass may be in g instead of kg"},
      {"InertiaInGramSquareMillimetres", [](Flown& f) { set_mass(f, 1.5, 1e9); },
       "may be in g mm^2 instead of kg m^2"},
      {"InertiaOfPoints", [](Flown& f) { set_mass(f, 1.5, 1e-3); }, "is too small"},
      {"CoefficientPerRpm",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.thrust_coefficient /= 91.2; }); },
       "thrust_coefficient may be in N over (rev/min)^2"},
      {"SpeedInRevolutionsASecond",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.omega_max_rad_s /= 2 * M_PI; }); },
       "omega_max_rad_s may be in rev/s"},
      {"CoefficientOfAForceInKilograms",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.thrust_coefficient /= 9.80665; }); },
       "thrust_coefficient may be of a force in kg"},
      {"TorqueCoefficientTooLarge",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.torque_coefficient *= 1000; }); },
       "N m for each N of thrust: torque_coefficient may be of another unit"},
      {"TorqueCoefficientPerRpm",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.torque_coefficient /= 91.2; }); },
       "and without any loss it would be"},
      {"RotorInertiaInKilogramSquareMillimetres",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.inertia_kg_m2 *= 1e6; }); },
       "the rotor's may be in kg mm^2 instead of kg m^2"},
      {"AirInGramsACubicMetre",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.reference_density_kg_m3 = 1225; }); },
       "reference_density_kg_m3 of its rotors is 1.22e+03, and air has about 1.2"},
      {"SpinOfOneRotor", [](Flown& f) { f.vehicle.rotors[1].spin *= -1; },
       "a spin or a place may be wrong"},
      {"AllSpinsTheSame", [](Flown& f) { each_rotor(f, [](auto& r) { r.spin = 1; }); },
       "a spin or a place may be wrong"},
      {"LagInMilliseconds", [](Flown& f) { f.vehicle.rotors[2].params.time_constant_up_s = 20; },
       "time constant of 20 s: it may be in ms"},
      {"RadiusInMillimetres",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.radius_m *= 1000; }); },
       "radius_m may be in mm instead of m"},
      {"PropellersThatOverlap",
       [](Flown& f) { each_rotor(f, [](auto& r) { r.params.radius_m *= 2; }); },
       "the propellers of rotors 1 and "}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    Flown flown = load(test::kSourceDir / "config/vehicles/quad_x.yaml");
    row.change(flown);
    EXPECT_THAT(implausible(flown.vehicle, flown.model), ElementsAre(HasSubstr(row.sentence)));
  }
}

TEST(Plausibility, SpeedsInRevolutionsAMinuteShowInThrustAndTips) {
  Flown flown = load(test::kSourceDir / "config/vehicles/quad_x.yaml");
  each_rotor(flown, [](base::Rotor& rotor) { rotor.params.omega_max_rad_s *= 9.549; });
  EXPECT_THAT(implausible(flown.vehicle, flown.model),
              ElementsAre(HasSubstr("omega_max_rad_s may be in rev/min"),
                          HasSubstr("omega_max_rad_s may be in rev/min instead of rad/s")));
}

TEST(Plausibility, PropellersMayOverlapInTwoHeightsOrOnOneAxis) {
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(0.13, -0.2, 0.05), Eigen::Vector3d(0, 0, 0)}) {
    Flown flown = load(test::kSourceDir / "config/vehicles/quad_x.yaml");
    flown.vehicle.rotors.resize(2);
    flown.vehicle.rotors[1].position_B_m = flown.vehicle.rotors[0].position_B_m + place;
    for (const std::string& warning : implausible(flown.vehicle, flown.model)) {
      EXPECT_THAT(warning, testing::Not(HasSubstr("overlap")));
    }
  }
}

TEST(Plausibility, GravityPointsDownInMetres) {
  EXPECT_FALSE(implausible_gravity({0, 0, -9.80665}));
  EXPECT_FALSE(implausible_gravity({0, 0, -1.62})) << "the Moon";
  EXPECT_FALSE(implausible_gravity({0, 0, 0}));
  EXPECT_THAT(implausible_gravity({0, 0, -32.174}).value_or(""), HasSubstr("may be in ft/s^2"));
  EXPECT_THAT(implausible_gravity({0, 0, -1}).value_or(""), HasSubstr("may be in g instead"));
  EXPECT_THAT(implausible_gravity({0, 0, 9.80665}).value_or(""), HasSubstr("does not point down"));
}

}  // namespace
}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_environment.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "libsim/core/load/sdf_geometry.hpp"
#include "libsim/core/load/sdf_omissions.hpp"

namespace cas::sim {

namespace {

// As `step_us` of a configuration; with a step of zero time would stand still.
constexpr double kShortestStep_s = 1e-4;
constexpr double kLongestStep_s = 0.01;
// As `speed`, `home` and `gravity_m_s2` of a configuration.
constexpr double kSlowest = 1e-3;
constexpr double kFastest = 1e3;
constexpr double kLowestHome_m = -1000;
constexpr double kHighestHome_m = 10'000;
constexpr double kMostGravity_m_s2 = 100;
constexpr double kMostWind_m_s = 100;

/// A child that the file has, not a default that libsdformat adds.
sdf::ElementPtr set_child(const sdf::ElementPtr& element, const std::string& name) {
  if (!element || !element->HasElement(name)) return nullptr;
  sdf::ElementPtr found = element->GetElement(name);
  return found->GetExplicitlySetInFile() ? found : nullptr;
}

class Surroundings {
 public:
  explicit Surroundings(WorldModel& model) : model_(model) {}

  void run(const sdf::World& world) {
    take_motion(world);
    take_physics(world);
    take_home(world);
    take_magnetic_field(world.Element());
    take_atmosphere(world);
  }

 private:
  void take_motion(const sdf::World& world) {
    model_.gravity_W = to_eigen(world.Gravity());
    model_.wind_W = to_eigen(world.WindLinearVelocity());
    if (!is_within(model_.gravity_W.norm(), 0, kMostGravity_m_s2) ||
        !is_within(model_.wind_W.norm(), 0, kMostWind_m_s)) {
      throw base::ConfigError(place_of(*world.Element()) +
                              ": <gravity> must lie within 100 m/s^2, the <linear_velocity> of "
                              "<wind> within 100 m/s");
    }
  }

  void take_physics(const sdf::World& world) {
    const sdf::Physics* const physics = world.PhysicsDefault();
    // Without <physics> libsdformat makes one up.
    if (physics == nullptr || !world.Element()->HasElement("physics")) return;
    const double step_s = physics->MaxStepSize();
    if (step_s >= kShortestStep_s && step_s <= kLongestStep_s) {
      model_.step = base::from_seconds(step_s);
    } else {
      warn(place_of(*physics->Element()), "<max_step_size> must lie in [0.0001, 0.01] s; left out");
    }
    if (is_within(physics->RealTimeFactor(), kSlowest, kFastest)) {
      model_.real_time_factor = physics->RealTimeFactor();
    } else {
      warn(place_of(*physics->Element()),
           "<real_time_factor> must lie in [0.001, 1000]; left out ('pace: free_run' waits for "
           "nothing)");
    }
  }

  void take_home(const sdf::World& world) {
    const auto* const place = world.SphericalCoordinates();
    if (place == nullptr || !world.Element()->HasElement("spherical_coordinates")) return;
    const base::Geodetic home{.lat_deg = place->LatitudeReference().Degree(),
                              .lon_deg = place->LongitudeReference().Degree(),
                              .alt_m = place->ElevationReference()};
    if (!is_within(home.lat_deg, -90, 90) || !is_within(home.lon_deg, -180, 180) ||
        !is_within(home.alt_m, kLowestHome_m, kHighestHome_m)) {
      throw base::ConfigError(place_of(*world.Element()->GetElement("spherical_coordinates")) +
                              ": <spherical_coordinates>: <latitude_deg> must lie in [-90, 90], "
                              "<longitude_deg> in [-180, 180], <elevation> in [-1000, 10000] m");
    }
    model_.home = home;
    const sdf::ElementPtr element = set_child(world.Element(), "spherical_coordinates");
    for (const char* name : {"latitude_deg", "longitude_deg"}) {
      if (!element || set_child(element, name)) continue;
      warn(place_of(*element),
           "<spherical_coordinates> has no <" + std::string(name) + ">: 0, as SDF has it");
    }
    if (std::abs(place->HeadingOffset().Degree()) > 1e-9) {
      warn(place_of(*world.Element()->GetElement("spherical_coordinates")),
           "<heading_deg> is left out: x is east here");
    }
  }

  /// SDF has it in tesla, in the axes of <spherical_coordinates>: those of W. Where it is not in
  /// the file the Earth's field is taken, not SDF's default.
  void take_magnetic_field(const sdf::ElementPtr& world) {
    sdf::ElementPtr field = set_child(world, "magnetic_field");
    if (!field) field = set_child(set_child(world, "physics"), "magnetic_field");  // SDF 1.5
    if (!field) return;
    const Eigen::Vector3d field_T = to_eigen(field->Get<ignition::math::Vector3d>());
    constexpr double kMost_T = 1e-3;  // twenty times the Earth's: sensors end there
    constexpr double kGaussPerTesla = 1e4;
    if (field_T.allFinite() && field_T.norm() <= kMost_T) {
      model_.magnetic_field_W = kGaussPerTesla * field_T;
    } else {
      warn(place_of(*field), "<magnetic_field> must lie in [0, 0.001] T; left out");
    }
  }

  /// Temperature, its gradient and pressure at sea level; SDF knows no other kind of air.
  void take_atmosphere(const sdf::World& world) {
    const sdf::Atmosphere* const air = world.Atmosphere();
    const sdf::ElementPtr element = set_child(world.Element(), "atmosphere");
    if (air == nullptr || !element) return;
    const base::Atmosphere wanted{.temperature_K = air->Temperature().Kelvin(),
                                  .temperature_gradient_K_m = air->TemperatureGradient(),
                                  .pressure_Pa = air->Pressure()};
    if (is_within(wanted.temperature_K, 150, 400) &&
        is_within(wanted.pressure_Pa, 1'000, 200'000) &&
        is_within(wanted.temperature_gradient_K_m, -0.05, 0.05)) {
      model_.atmosphere = wanted;
    } else {
      warn(place_of(*element),
           "<atmosphere>: <temperature> must lie in [150, 400] K, <temperature_gradient> in "
           "[-0.05, 0.05] K/m, <pressure> in [1000, 200000] Pa; left out");
    }
  }

  void warn(const std::string& place, const std::string& sentence) {
    model_.warnings.push_back(place + ": " + sentence);
  }

  WorldModel& model_;
};

}  // namespace

void take_sdf_environment(const sdf::World& world, WorldModel& model) {
  Surroundings(model).run(world);
}

}  // namespace cas::sim

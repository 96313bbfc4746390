// SPDX-License-Identifier: BSD-3-Clause
// Ground from elevation files: as contacts, rays and flights far away meet it.
#include "libsim/core/terrain/terrain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/earth/frames.hpp"
#include "base/random.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "libsim/core/run/start.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/libsim/support/elevation_files.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;

/// Hills of 300 m, 5 km wide.
double hills_m(double lat_deg, double lon_deg) {
  return 800 + 150 * std::sin(130 * lat_deg) + 150 * std::cos(90 * lon_deg);
}

/// A world of one to four HGT files around home.
class Country {
 public:
  template <class Height>
  Country(const base::Geodetic& home, int samples, Height height_m) : projection_(home) {
    for (const double d_lat : {-0.4, 0.4}) {
      for (const double d_lon : {-0.4, 0.4}) {
        const double south = std::floor(home.lat_deg + d_lat);
        const double west = std::floor(std::remainder(home.lon_deg + d_lon, 360));
        char name[32];
        std::snprintf(name, sizeof(name), "%c%02d%c%03d.hgt", south < 0 ? 'S' : 'N',
                      std::abs(static_cast<int>(south)), west < 0 ? 'W' : 'E',
                      std::abs(static_cast<int>(west)));
        const auto file = folder_.path() / name;
        if (!std::filesystem::exists(file)) {
          test::write_hgt(file, samples, south, west, height_m);
        }
      }
    }
    terrain_ = std::make_shared<const Terrain>(
        TerrainConfig{.files = {folder_.path()}, .geoid = {}}, projection_);
  }

  const Terrain& terrain() const { return *terrain_; }
  const base::LocalProjection& projection() const { return projection_; }
  std::filesystem::path folder() const { return folder_.path(); }

  WorldModel world(double gravity_m_s2 = test::kGravity) const {
    WorldModel model;
    model.gravity_W = {0, 0, -gravity_m_s2};
    model.terrain = terrain_;
    return model;
  }
  std::unique_ptr<SimWorld> make(double gravity_m_s2 = test::kGravity) const {
    return std::make_unique<SimWorld>(world(gravity_m_s2), projection_, 2026.5, Integrator::kRk4);
  }

 private:
  cas::test::TemporaryFolder folder_;
  base::LocalProjection projection_;
  std::shared_ptr<const Terrain> terrain_;
};

constexpr base::Geodetic kHome{.lat_deg = 47.5, .lon_deg = 8.5, .alt_m = 800};

TEST(Terrain, RaysMeetTheTrianglesThatContactsMeet) {
  const Country country(kHome, 1201, hills_m);
  const Terrain& terrain = country.terrain();
  WorldModel meshes;
  for (const int i : {-2, -1, 0, 1}) {
    for (const int j : {-2, -1, 0, 1}) {
      const double size = static_cast<double>(Terrain::kPatchCells) * terrain.cell_m();
      meshes.statics.push_back(
          test::standing("patch", Mesh{std::make_shared<TriangleMesh>(terrain.patch(i, j))},
                         {i * size, j * size, terrain.height_m(i * size, j * size)}));
    }
  }
  ContactSolver ode(Vector3d::Zero());
  for (const Shape& shape : meshes.statics) ode.add_static(shape);
  base::NormalRandom random(3);
  int met = 0;
  for (int n = 0; n < 20'000; ++n) {
    const Vector3d from(200 * random(), 200 * random(), 100 + 50 * random());
    const Vector3d along = Vector3d(random(), random(), 0.5 * random()).normalized();
    const auto want = ode.ray_to_world(from, along, 400);
    const auto got = terrain.cast(from, along, 400);
    ASSERT_EQ(got.has_value(), want.has_value()) << from.transpose() << "  " << along.transpose();
    if (!got) continue;
    ++met;
    EXPECT_NEAR(got->distance_m, want->distance_m, 0.02);
    EXPECT_LT(got->normal.dot(along), 0);
  }
  EXPECT_GT(met, 2000);
}

TEST(Terrain, KeepsTheNewestTiles) {
  const Country country(kHome, 1201, hills_m);
  const Terrain& terrain = country.terrain();
  const double tile_m = 32 * terrain.cell_m();
  const double first_m = terrain.height_m(10, 10);
  for (int i = 0; i < 35; ++i) {
    for (int j = 0; j < 35; ++j) terrain.height_m((i + 0.5) * tile_m, (j + 0.5) * tile_m);
  }
  EXPECT_EQ(terrain.tiles(), 1024U);  // 9 MB
  EXPECT_EQ(terrain.height_m(10, 10), first_m);
}

TEST(Terrain, HoldsACrateFarAwayAsAtHome) {
  const Country country({47.5, 8.7, 0}, 301, [](double lat, double) { return 50 * lat; });
  double sunk_m[2];
  for (const int far : {0, 1}) {
    auto world = country.make();
    const VehicleModel crate = test::crate();
    StartPose pose{.x_m = 3 + 52'000.0 * far, .y_m = 7 + 40'000.0 * far};
    pose.z_m = standing_height(*world, crate, pose);
    world->add_vehicle(crate, pose);
    world->start();
    for (int i = 0; i < 3000; ++i) world->advance(test::kStep_s);
    const BodyState& rests = world->state(test::kVehicle);
    const Vector3d p_W = rests.p_WB;
    EXPECT_TRUE(world->in_contact(test::kVehicle));
    for (int i = 0; i < 100; ++i) world->advance(test::kStep_s);
    EXPECT_EQ(rests.p_WB, p_W);  // held
    sunk_m[far] = p_W.z() - test::kCrateSize.z() / 2 - country.terrain().height_m(p_W.x(), p_W.y());
  }
  EXPECT_LT(std::abs(sunk_m[0]), 2e-3);
  EXPECT_NEAR(sunk_m[1], sunk_m[0], 1e-5);
}

TEST(Terrain, StopsACrateThatFallsAt90MetresASecond) {
  const Country country(kHome, 1201, hills_m);
  auto world = country.make();
  world->add_vehicle(test::crate(), {.x_m = 777, .y_m = -555, .z_m = 600});
  world->start();
  for (int i = 0; i < 20'000; ++i) {
    world->advance(test::kStep_s);
    ASSERT_FALSE(world->is_below_everything(test::kVehicle)) << i << " ms";
  }
  EXPECT_TRUE(world->in_contact(test::kVehicle));
  EXPECT_LT(world->state(test::kVehicle).v_WB.norm(), 1e-3);
}

TEST(Terrain, FlightOf45KilometresHasNoJump) {
  const Country country(kHome, 301, hills_m);
  auto world = country.make(0);
  world->add_vehicle(test::crate(), {.x_m = -5000, .y_m = -20'000, .z_m = 1000, .yaw_deg = 0});
  world->start();
  constexpr double kPush_s = 0.01;
  const Vector3d push_W = test::kCrateMass / kPush_s * Vector3d(24, 32, 0);  // 40 m/s
  world->add_wrench(test::kVehicle, {.force_B = push_W, .torque_B = Vector3d::Zero()});
  world->advance(kPush_s);
  const BodyState& state = world->state(test::kVehicle);
  const Vector3d v_W = state.v_WB;
  ASSERT_NEAR((v_W - Vector3d(24, 32, 0)).norm(), 0, 1e-9) << v_W.transpose();
  const Vector3d start_W = state.p_WB;
  Vector3d before_W = start_W;
  double ground_m = world->environment(test::kVehicle).height_above_ground_m;
  base::Geodetic before = country.projection().to_geodetic(base::swap_WN(before_W));
  for (int i = 1; i <= 112'500; ++i) {
    world->advance(kPush_s);
    const Vector3d step_W = state.p_WB - before_W;
    ASSERT_NEAR((step_W - kPush_s * v_W).norm(), 0, 1e-9);
    const auto place = country.projection().to_geodetic(base::swap_WN(state.p_WB));
    ASSERT_NEAR(place.lat_deg - before.lat_deg, v_W.y() * kPush_s / 111'195, 3e-8);
    ASSERT_NEAR(place.lon_deg - before.lon_deg, v_W.x() * kPush_s / 75'123, 6e-8);
    ASSERT_NEAR(place.alt_m - before.alt_m, v_W.z() * kPush_s, 1e-6);
    // Rangefinder and height over ground: hills are no steeper than 50 %.
    const double height_m = world->environment(test::kVehicle).height_above_ground_m;
    ASSERT_LT(std::abs(height_m - ground_m), 0.5 * 40 * kPush_s);
    const auto range_m = world->ray_distance(test::kVehicle, state.p_WB, -Vector3d::UnitZ(), 5000);
    ASSERT_NEAR(range_m.value(), height_m, 1e-6);
    before_W = state.p_WB;
    before = place;
    ground_m = height_m;
  }
  EXPECT_NEAR((state.p_WB - start_W).norm(), 45'000, 1e-3);
}

/// The crate stands 10 km north-east of home; its place on the sphere by the spherical law.
TEST(FarPlaces, StartsAtItsPlaceAndHeight) {
  struct Place {
    const char* name;
    base::Geodetic home;
    double elevation_m;
  };
  const Place rows[] = {{"Antimeridian", {.lat_deg = -17.3, .lon_deg = 179.97, .alt_m = 10}, 37},
                        {"80Degrees", {.lat_deg = 80.1, .lon_deg = 16.5, .alt_m = 0}, 255},
                        {"BelowSeaLevel", {.lat_deg = 31.5, .lon_deg = 35.5, .alt_m = -400}, -428}};
  for (const auto& [name, home, elevation_m] : rows) {
    SCOPED_TRACE(name);
    const Country country(home, 121, [&](double, double) { return elevation_m; });
    auto world = country.make();
    const VehicleModel crate = test::crate();
    StartPose pose{.x_m = 10'000 * std::sqrt(0.5), .y_m = 10'000 * std::sqrt(0.5)};
    pose.z_m = standing_height(*world, crate, pose);
    world->add_vehicle(crate, pose);
    const auto place =
        country.projection().to_geodetic(base::swap_WN(world->state(test::kVehicle).p_WB));
    const double c = 10'000 / 6'371'000.0;
    const double lat_0 = home.lat_deg * M_PI / 180;
    const double lat =
        std::asin(std::sin(lat_0) * std::cos(c) + std::cos(lat_0) * std::sin(c) * std::sqrt(0.5));
    const double d_lon = std::asin(std::sin(c) * std::sqrt(0.5) / std::cos(lat));
    EXPECT_NEAR(place.lat_deg, lat * 180 / M_PI, 1e-9);
    EXPECT_NEAR(std::remainder(place.lon_deg - home.lon_deg, 360), d_lon * 180 / M_PI, 1e-9);
    EXPECT_LE(std::abs(place.lon_deg), 180);
    EXPECT_NEAR(place.alt_m, elevation_m + test::kCrateSize.z() / 2, 1e-6);
  }
}

TEST(Terrain, IsGroundOfASimulationFile) {
  const Country country(kHome, 121, [](double, double) { return 600.0; });
  const std::string key = "terrain: {files: [" + country.folder().string() + "]}\n";
  const std::string flat = "world: {gravity_m_s2: 9.80665, ground: false}\n";
  SimRunner runner(test::config(test::vehicle("iris"), key, flat), {});
  runner.start();
  for (int i = 0; i < 100; ++i) runner.step();
  const World& world = runner.world();
  EXPECT_TRUE(world.in_contact(VehicleId{0}));  // home is at 488 m
  EXPECT_NEAR(world.state(VehicleId{0}).p_WB.z(), 600 - 488, 0.5);
  EXPECT_NE(test::refusal([&] {
              SimRunner low(test::config(test::vehicle("iris", "{z_m: 5}"), key, flat), {});
            }).find("obstacle 'terrain': the vehicle starts inside it"),
            std::string::npos);
}

TEST(Terrain, KeysAreRefusedWithTheirPlace) {
  const auto says = [](const std::string& key, const std::string& world) {
    return test::refusal([&] { test::config(test::vehicle("iris"), key, world); });
  };
  const std::string none = says("terrain: {files: [nowhere]}\n", test::kFlat);
  EXPECT_NE(none.find("terrain.files"), std::string::npos) << none;
  EXPECT_NE(none.find("there is no file or folder"), std::string::npos) << none;
  const std::string both = says("terrain: {files: [/tmp]}\n", test::kFlat);
  EXPECT_NE(both.find("the terrain is the ground: give false"), std::string::npos) << both;
  const Country country(kHome, 11, hills_m);
  const std::string elsewhere = test::refusal([&] {
    const Terrain terrain({.files = {country.folder()}, .geoid = {}},
                          base::LocalProjection({.lat_deg = -50, .lon_deg = 20, .alt_m = 0}));
  });
  EXPECT_NE(elsewhere.find("no elevation file has home (-50.000000, 20.000000)"),
            std::string::npos);
}

}  // namespace
}  // namespace cas::sim

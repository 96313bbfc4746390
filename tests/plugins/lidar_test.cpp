// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "base/angles.hpp"
#include "libsim/api/mavlink_message.hpp"
#include "plugins/lidar/cloud_file.hpp"
#include "plugins/lidar/lidar_model.hpp"
#include "plugins/mavlink_interface/hil_conversion.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::chrono::milliseconds;

constexpr VehicleId kOwn{0};
constexpr double kLidarStep_s = 0.004;
/// Points are kept in single precision.
constexpr double kSinglePrecision_m = 2e-5;

std::filesystem::path shipped_pattern(const std::string& name) {
  return std::filesystem::path(cas::test::source_dir()) / "config/lidars" / (name + ".yaml");
}

LidarParams vlp16() {
  return {.beams = load_lidar_pattern(shipped_pattern("vlp16")).beams,
          .rate_hz = 10,
          .min_m = 0.1,
          .max_m = 100};
}

/// A half-space, solid behind the plane through `at`. @param n  towards the open side
Shape wall(const Vector3d& at, const Vector3d& n) {
  Shape shape = test::standing("wall", Plane{}, at);
  shape.pose.rotate(Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n));
  return shape;
}

std::unique_ptr<SimWorld> world_of(std::vector<Shape> statics) {
  WorldModel model;
  model.statics = std::move(statics);
  auto world = test::make_world(model);
  world->add_vehicle(test::crate(), {.z_m = 2});
  world->expect_rays();
  world->start();
  return world;
}

/// 10 m by 8 m by 3 m.
std::vector<Shape> box_room() {
  return {wall({0, 0, 0}, {0, 0, 1}),  wall({0, 0, 3}, {0, 0, -1}), wall({5, 0, 0}, {-1, 0, 0}),
          wall({-5, 0, 0}, {1, 0, 0}), wall({0, 4, 0}, {0, -1, 0}), wall({0, -4, 0}, {0, 1, 0})};
}

/// From a place in the room along a direction.
double to_wall_of_room(const Vector3d& o, const Vector3d& d) {
  const Vector3d low(-5, -4, 0);
  const Vector3d high(5, 4, 3);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Index i : {0, 1, 2}) {
    if (d[i] != 0) nearest = std::min(nearest, ((d[i] > 0 ? high : low)[i] - o[i]) / d[i]);
  }
  return nearest;
}

/// Motion of a vehicle by time, s.
using Motion = std::function<BodyState(double)>;

Motion resting(const Vector3d& p_WB, const Quaterniond& q_WB = Quaterniond::Identity()) {
  return [=](double) {
    BodyState state{.p_WB = p_WB, .q_WB = q_WB};
    return state;
  };
}

std::vector<LidarScan> scan(const SimWorld& world, const LidarParams& params, const Motion& motion,
                            double duration_s, std::uint64_t seed = 1) {
  std::vector<LidarScan> scans;
  LidarModel model(params, seed, [&](const LidarScan& whole) { scans.push_back(whole); });
  const auto time = [](int step) { return base::SimTime(base::from_seconds(step * kLidarStep_s)); };
  for (int step = 0; step < std::lround(duration_s / kLidarStep_s); ++step) {
    model.aim(time(step), time(step + 1), motion(step * kLidarStep_s),
              motion((step + 1) * kLidarStep_s));
    world.cast(kOwn, model.origins_W(), model.directions_W(), params.max_m + 1, model.hits());
    model.take_hits();
  }
  return scans;
}

TEST(LidarPattern, OfTheVlp16TurnsClockwise) {
  const auto beams = load_lidar_pattern(shipped_pattern("vlp16")).beams;
  ASSERT_EQ(beams.size(), 1808U * 16U);
  const double low = -15 * base::kRadPerDeg;
  EXPECT_TRUE(beams[0].direction_S.isApprox(Vector3d(std::cos(low), 0, std::sin(low)), 1e-12));
  EXPECT_EQ(beams[0].share, 0);
  const LidarBeam& quarter = beams[452 * 16 + 1];  // a quarter of a turn: to the right
  EXPECT_EQ(quarter.share, 0.25);
  EXPECT_EQ(quarter.ring, 1);
  const double high = 1 * base::kRadPerDeg;
  EXPECT_TRUE(quarter.direction_S.isApprox(Vector3d(0, -std::cos(high), std::sin(high)), 1e-12));
}

TEST(LidarPattern, OfTheOusterStaggersItsBeams) {
  const auto beams = load_lidar_pattern(shipped_pattern("ouster_os1_64")).beams;
  ASSERT_EQ(beams.size(), 1024U * 64U);
  const auto azimuth_deg = [&](std::size_t beam) {
    return std::atan2(beams[beam].direction_S.y(), beams[beam].direction_S.x()) * base::kDegPerRad;
  };
  EXPECT_NEAR(azimuth_deg(0), 3.164, 1e-9);
  EXPECT_NEAR(azimuth_deg(1), 1.055, 1e-9);
  EXPECT_NEAR(azimuth_deg(256 * 64), 3.164 - 90, 1e-9);
}

TEST(LidarPatternRefuses, WithFileAndLine) {
  struct PatternCase {
    const char* name;
    const char* file;
    const char* text;
    const char* says;
  };
  const PatternCase rows[] = {
      {"NoHeader", "a.csv", "0,0,0\n", "a.csv:1: the first line must be"},
      {"TwoNumbers", "a.csv", "share,azimuth_deg,elevation_deg\n0,0\n", "a.csv:2: needs 3 numbers"},
      {"SharesOutOfOrder", "a.csv", "share,azimuth_deg,elevation_deg\n0.5,0,0\n0.4,0,0\n",
       "a.csv:3: a share is"},
      {"Empty", "a.csv", "share,azimuth_deg,elevation_deg\n", "has no beam"},
      {"SteepBeamOfACsv", "a.csv", "share,azimuth_deg,elevation_deg\n0,0,-91\n",
       "a.csv:2: an elevation is from -90 to 90 degrees"},
      {"FarTurn", "a.csv", "share,azimuth_deg,elevation_deg\n0,361,0\n",
       "a.csv:2: an azimuth is from -360 to 360 degrees"},
      {"PictureWithoutHeight", "a.yaml", "width: 4\nhorizontal_fov_deg: 60\n",
       "key 'height' is missing"},
      {"PictureTooLarge", "a.yaml", "width: 1001\nheight: 1000\nhorizontal_fov_deg: 60\n",
       "has more than a million pixels"},
      {"PictureOfHalfTheWorld", "a.yaml", "width: 4\nheight: 4\nhorizontal_fov_deg: 180\n",
       "a.yaml:3: horizontal_fov_deg: 180 must lie in [1, 170]"},
      {"NoColumns", "a.yaml", "elevations_deg: [0]\n", "columns"},
      {"SteepBeam", "a.yaml", "columns: 4\nelevations_deg: [91]\n",
       "a.yaml:2: elevations_deg: are from -90 to 90"},
      {"TooFewOffsets", "a.yaml", "columns: 4\nelevations_deg: [0, 1]\nazimuth_offsets_deg: [1]\n",
       "a.yaml:3: azimuth_offsets_deg: has one number for each elevation"},
      {"UnknownKey", "a.yaml", "columns: 4\nelevations_deg: [0]\nhz: 3\n", "hz"}};
  for (const auto& [name, file, text, says] : rows) {
    SCOPED_TRACE(name);
    const cas::test::TemporaryFolder folder;
    std::ofstream(folder.path() / file) << text;
    EXPECT_THAT(cas::test::refusal([&] { load_lidar_pattern(folder.path() / file); }),
                testing::HasSubstr(says));
  }
}

TEST(Lidar, FiresEachBeamOfEachTurnOnce) {
  const auto world = world_of(box_room());
  const auto scans = scan(*world, vlp16(), resting({0, 0, 1.2}), 1);
  ASSERT_EQ(scans.size(), 10U);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].number, i);
    EXPECT_EQ(scans[i].points.size(), 1808U * 16U) << "each meets a wall";
    EXPECT_NEAR(base::to_seconds(scans[i].begin), 0.1 * static_cast<double>(i), 1e-9);
  }
}

TEST(Lidar, MeasuresARoomExactly) {
  const auto world = world_of(box_room());
  LidarParams params = vlp16();
  params.position_B_m = {0.1, 0.05, -0.2};
  params.q_BS = Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, -2, 0.5).normalized()));
  const Quaterniond q_WB(Eigen::AngleAxisd(2, Vector3d(0.2, 0.1, 1).normalized()));
  const Vector3d p_WB(1, -2, 1.3);
  const Vector3d o_W = p_WB + q_WB * params.position_B_m;
  const auto scans = scan(*world, params, resting(p_WB, q_WB), 0.1);
  ASSERT_EQ(scans.size(), 1U);
  ASSERT_EQ(scans[0].points.size(), params.beams.size());
  for (std::size_t i = 0; i < params.beams.size(); ++i) {
    const Vector3d d_S = params.beams[i].direction_S;
    const double distance_m = to_wall_of_room(o_W, q_WB * (params.q_BS * d_S));
    const Vector3d p_S = scans[0].points[i].p_S.cast<double>();
    ASSERT_TRUE(p_S.isApprox(distance_m * d_S, 1e-6)) << i << ": " << p_S.transpose();
  }
}

TEST(Lidar, MeasuresASphereExactly) {
  const Vector3d centre_W(6, 1, 2);
  constexpr double kRadius_m = 1.5;
  const auto world = world_of({test::standing("ball", Sphere{kRadius_m}, centre_W)});
  const Vector3d o_W(0, 0, 1.5);
  const auto scans = scan(*world, vlp16(), resting(o_W), 0.1);
  ASSERT_EQ(scans.size(), 1U);
  std::size_t seen = 0;
  for (const LidarBeam& beam : vlp16().beams) {
    const double along = beam.direction_S.dot(centre_W - o_W);
    const double off = ((centre_W - o_W) - along * beam.direction_S).norm();
    seen += along > 0 && off < kRadius_m ? 1U : 0U;
  }
  EXPECT_GT(seen, 300U);
  EXPECT_EQ(scans[0].points.size(), seen);
  for (const CloudPoint& point : scans[0].points) {
    const Vector3d p_W = o_W + point.p_S.cast<double>();
    ASSERT_NEAR((p_W - centre_W).norm(), kRadius_m, kSinglePrecision_m);
    const double cosine = (p_W - centre_W).dot(o_W - p_W) / (kRadius_m * (o_W - p_W).norm());
    ASSERT_NEAR(point.cosine, cosine, 1e-4);
  }
}

/// A picture of a flat wall is bent by the motion during the turn, by as much as the stamps say.
TEST(Lidar, FiresFromWhereTheMovingSensorIs) {
  const auto world = world_of({wall({30, 0, 0}, {-1, 0, 0})});
  const Vector3d v_W(12, 3, 0);
  constexpr double kTurning_rad_s = 1.5;
  const Motion flight = [&](double t) {
    BodyState state{.p_WB = Vector3d(0, 0, 5) + t * v_W};
    state.q_WB = Eigen::AngleAxisd(kTurning_rad_s * t, Vector3d::UnitZ());
    return state;
  };
  const auto scans = scan(*world, vlp16(), flight, 0.2);
  ASSERT_EQ(scans.size(), 2U);
  double last = 0;
  for (const LidarScan& turn : scans) {
    EXPECT_TRUE(turn.p_WS.isApprox(flight(base::to_seconds(turn.begin)).p_WB, 1e-9));
    for (const CloudPoint& point : turn.points) {
      const double t = base::to_seconds(turn.begin) + point.time_s;
      const BodyState vehicle = flight(t);
      const Vector3d p_W = vehicle.p_WB + vehicle.q_WB * point.p_S.cast<double>();
      ASSERT_NEAR(p_W.x(), 30, 2e-4) << "at " << t << " s";  // single precision of 100 m, and of t
      ASSERT_NEAR((point.p_W.cast<double>() - p_W).norm(), 0, 2e-4) << "the same place in W";
      ASSERT_GE(t, last - 1e-6);
      last = t;
    }
  }
  EXPECT_GT(last, 0.19);
}

TEST(Lidar, LosesWhatItsSheetSays) {
  const auto world = world_of(box_room());
  const Motion motion = resting({0, 0, 1.5});
  const auto returns = [&](const std::function<void(LidarParams&)>& change) {
    LidarParams params = vlp16();
    change(params);
    return static_cast<double>(scan(*world, params, motion, 0.1).at(0).points.size()) /
           static_cast<double>(params.beams.size());
  };
  EXPECT_EQ(returns([](LidarParams&) {}), 1);
  EXPECT_NEAR(returns([](LidarParams& p) { p.dropout = 0.25; }), 0.75, 0.01);
  EXPECT_EQ(returns([](LidarParams& p) { p.min_m = 7; }), 0);
  EXPECT_EQ(returns([](LidarParams& p) { p.max_m = 3.9; }), 0);
  // The level beams of a room in a ring: those within 10 degrees of a wall's normal.
  const auto level = [](LidarParams& p) {
    std::erase_if(p.beams, [](const LidarBeam& beam) { return beam.ring != 1; });
    for (LidarBeam& beam : p.beams) beam.direction_S.z() = 0;
    for (LidarBeam& beam : p.beams) beam.direction_S.normalize();
    p.least_cosine = std::cos(10 * base::kRadPerDeg);
  };
  EXPECT_NEAR(returns(level), 4 * 20 / 360.0, 0.003);
}

TEST(Lidar, ItsNoiseHasTheDeviationOfItsSheet) {
  const auto world = world_of(box_room());
  LidarParams noisy = vlp16();
  noisy.stddev_m = 0.02;
  const Motion motion = resting({0, 0, 1.5});
  const auto truth = scan(*world, vlp16(), motion, 0.1).at(0).points;
  const auto points = scan(*world, noisy, motion, 0.1, 5).at(0).points;
  ASSERT_EQ(points.size(), truth.size());
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double error = points[i].p_S.norm() - truth[i].p_S.norm();
    sum += error;
    squares += error * error;
  }
  const auto n = static_cast<double>(points.size());
  EXPECT_NEAR(sum / n, 0, 4 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 0.0005);
  EXPECT_EQ(scan(*world, noisy, motion, 0.1, 5).at(0).points[100].p_S, points[100].p_S);
}

TEST(ObstacleSector, IsAboutItsDirection) {
  struct SectorCase {
    double azimuth_deg;
    std::size_t sector;
  };
  const SectorCase rows[] = {{0, 0},   {2.4, 0},  {2.6, 1},  {-2.4, 0},  {-2.6, 71},
                             {90, 18}, {-90, 54}, {180, 36}, {357.6, 0}, {720 + 45, 9}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.azimuth_deg);
    EXPECT_EQ(ObstacleSectors::sector_of(row.azimuth_deg * base::kRadPerDeg), row.sector);
  }
}

TEST(ObstacleSectors, AreWhatMavlinkSays) {
  ObstacleSectors sectors;
  sectors.see_free(5 * base::kRadPerDeg);
  sectors.see_obstacle(10 * base::kRadPerDeg, 7.5);
  sectors.see_obstacle(10 * base::kRadPerDeg, 6.004);
  sectors.see_free(10 * base::kRadPerDeg);
  const auto packet = sectors.message(base::SimTime(milliseconds(1500)), 0.5, 100);
  EXPECT_EQ(packet.distances[0], 0xFFFF) << "unknown: nobody has looked";
  EXPECT_EQ(packet.distances[1], 10001) << "max_distance + 1: free";
  EXPECT_EQ(packet.distances[2], 600);
  // Fields in wire order, by the specification of message 330.
  const MavlinkMessage message = mavlink_message(packet);
  EXPECT_EQ(message.id, 330U);
  ASSERT_EQ(message.size, 167U);
  const auto at = [&](auto value, std::size_t place) {
    std::memcpy(&value, message.payload.data() + place, sizeof(value));
    return value;
  };
  EXPECT_EQ(at(std::uint64_t{}, 0), 1'500'000U);   // time_usec
  EXPECT_EQ(at(std::uint16_t{}, 8 + 2 * 2), 600);  // distances[2]
  EXPECT_EQ(at(std::uint16_t{}, 152), 50);         // min_distance, cm
  EXPECT_EQ(at(std::uint16_t{}, 154), 10000);      // max_distance, cm
  EXPECT_EQ(message.payload[156], 0);              // laser
  EXPECT_EQ(message.payload[157], 5);              // increment, deg
  EXPECT_EQ(at(float{}, 158), 5.0F);               // increment_f
  EXPECT_EQ(at(float{}, 162), 0.0F);               // angle_offset
  EXPECT_EQ(message.payload[166], 12);             // MAV_FRAME_BODY_FRD
}

/// A wall 6 m to the north and a post to the east, seen by a vehicle that looks north-east.
TEST(Lidar, FillsTheSectorsOfItsHeading) {
  const auto world =
      world_of({wall({0, 6, 0}, {0, -1, 0}), test::standing("post", Cylinder{0.5, 20}, {8, 0, 0}),
                test::standing("ground", Plane{})});
  LidarParams params = vlp16();
  params.obstacle_height_m = 0.5;
  const double north_east = 45 * base::kRadPerDeg;  // W is east, north, up
  for (const double pitch_deg : {0.0, -12.0}) {
    const Quaterniond q_WB(Eigen::AngleAxisd(north_east, Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(pitch_deg * base::kRadPerDeg, Vector3d::UnitY()));
    const auto scans = scan(*world, params, resting({0, 0, 3}, q_WB), 0.1);
    const auto distances = scans.at(0).sectors.message({}, 0.1, 100).distances;
    EXPECT_NEAR(distances[72 - 9], 600, 1) << "north is 45 degrees to the left";
    EXPECT_NEAR(distances[9], 750, 1) << "and east to the right";
    // The nearest place of the wall in the next but one sector is 7.5 degrees off its normal.
    EXPECT_NEAR(distances[72 - 9 + 2], 600 / std::cos(7.5 * base::kRadPerDeg), 2);
    EXPECT_EQ(distances[36], 10001) << "free: the ground is lower than the vehicle's height";
  }
}

/// The bytes of a file, or nothing.
std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

constexpr std::size_t kBytesOfPoint = 22;

TEST(LidarPlugin, WritesEachSecondScan) {
  const cas::test::TemporaryFolder folder;
  cas::test::PluginHarness harness(milliseconds(4), folder.path());
  harness.world.body.p_WB = {7, 8, 3};
  harness.add("lidar", "{pattern: " + shipped_pattern("vlp16").string() +
                           ", rate_hz: 10, min_m: 0.5, max_m: 100, cloud: pcd, cloud_every: 2}");
  harness.run(milliseconds(500));
  const auto clouds = folder.path() / "clouds";
  EXPECT_TRUE(bytes_of(clouds / "iris0_000001.pcd").empty());
  EXPECT_FALSE(bytes_of(clouds / "iris0_000004.pcd").empty());
  const std::string text = bytes_of(clouds / "iris0_000002.pcd");
  const std::string head = text.substr(0, text.find("DATA binary\n") + 12);
  // Of 16 beams 8 look down; the one at -1 degree meets the ground beyond 100 m.
  constexpr std::size_t kPoints = 1808U * 7U;
  EXPECT_THAT(head, testing::HasSubstr("\nFIELDS x y z intensity t ring\n"));
  EXPECT_THAT(head, testing::HasSubstr("\nPOINTS " + std::to_string(kPoints) + "\n"));
  EXPECT_THAT(head, testing::HasSubstr("\nVIEWPOINT 7.000000 8.000000 3.000000 1.0000"));
  ASSERT_EQ(text.size(), head.size() + kPoints * kBytesOfPoint);
  std::array<float, 5> point{};
  std::memcpy(point.data(), text.data() + head.size() + kBytesOfPoint * 5000, sizeof(point));
  EXPECT_NEAR(point[2], -3, kSinglePrecision_m) << "the ground is 3 m below";
  EXPECT_NEAR(point[4], 0.1 * (5000 / 7) / 1808, 1e-6) << "s since the turn began";
  harness.finish();
}

TEST(LidarPlugin, WritesPly) {
  const cas::test::TemporaryFolder folder;
  cas::test::PluginHarness harness(milliseconds(4), folder.path());
  harness.world.body.p_WB = {0, 0, 3};
  std::ofstream(folder.path() / "down.csv")
      << "share,azimuth_deg,elevation_deg\n0,0,-90\n0.5,0,-30\n";
  harness.add("lidar", "{pattern: " + (folder.path() / "down.csv").string() +
                           ", rate_hz: 20, min_m: 0.5, max_m: 100, cloud: ply, cloud_every: 1, "
                           "cloud_folder: a/b}");
  harness.run(milliseconds(100));
  const std::string text = bytes_of(folder.path() / "a/b/iris0_000001.ply");
  const std::string head = text.substr(0, text.find("end_header\n") + 11);
  EXPECT_THAT(head, testing::StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(head, testing::HasSubstr("\nelement vertex 2\n"));
  ASSERT_EQ(text.size(), head.size() + 2 * kBytesOfPoint);
  std::array<float, 5> point{};
  std::memcpy(point.data(), text.data() + head.size() + kBytesOfPoint, sizeof(point));
  EXPECT_NEAR(point[0], 3 / std::tan(30 * base::kRadPerDeg), 1e-5);
  EXPECT_NEAR(point[2], -3, 1e-5);
  EXPECT_NEAR(point[4], 0.025, 1e-6);
}

TEST(DepthCamera, ItsPixelsAreSquareAndCoverItsView) {
  const LidarPattern pattern = load_lidar_pattern(shipped_pattern("depth_camera"));
  ASSERT_TRUE(pattern.picture);
  ASSERT_EQ(pattern.beams.size(), 160U * 90U);
  const DepthPicture& picture = *pattern.picture;
  // The outer edges of the picture are half a pixel beyond the middles of the outer pixels.
  const Vector3d left = picture.ray_S(0, 45);
  EXPECT_NEAR(std::atan(left.y() + 0.5 / picture.focal_px), 43.5 * base::kRadPerDeg, 1e-12);
  const Vector3d first = picture.ray_S(7, 3);
  const Vector3d across = picture.ray_S(8, 3) - first;
  const Vector3d down = picture.ray_S(7, 4) - first;
  EXPECT_TRUE(across.isApprox(Vector3d(0, -1 / picture.focal_px, 0), 1e-9));
  EXPECT_TRUE(down.isApprox(Vector3d(0, 0, -1 / picture.focal_px), 1e-9));
  for (const std::size_t pixel : {0U, 159U, 160U, 14'399U}) {
    EXPECT_EQ(picture.pixel_of(7.3 * pattern.beams[pixel].direction_S), pixel);
    EXPECT_EQ(pattern.beams[pixel].ring, pixel / 160);
    EXPECT_EQ(pattern.beams[pixel].share, 0);
  }
  EXPECT_FALSE(picture.pixel_of({-1, 0, 0}));
}

/// Depth in mm of the pixels of a PGM, row by row.
std::vector<int> depths_of(const std::string& text, std::size_t pixels) {
  std::vector<int> depths;
  for (std::size_t at = text.size() - 2 * pixels; at < text.size(); at += 2) {
    depths.push_back(256 * static_cast<unsigned char>(text[at]) +
                     static_cast<unsigned char>(text[at + 1]));
  }
  return depths;
}

TEST(DepthCamera, MeasuresAWallAndTheGroundAlongItsAxis) {
  const LidarPattern pattern = load_lidar_pattern(shipped_pattern("depth_camera"));
  const DepthPicture& picture = *pattern.picture;
  const auto world = world_of({wall({0, 0, 0}, {0, 0, 1}), wall({5, 0, 0}, {-1, 0, 0})});
  const LidarParams params{.beams = pattern.beams,
                           .picture = pattern.picture,
                           .rate_hz = 10,
                           .min_m = 0.3,
                           .max_m = 100};
  constexpr double kHeight_m = 1.2;
  const auto scans = scan(*world, params, resting({0, 0, kHeight_m}), 0.1);
  ASSERT_EQ(scans.size(), 1U);
  const auto depths = depths_of(depth_text(scans[0], picture), picture.pixels());
  for (int row = 0; row < picture.height; ++row) {
    const double down = -picture.ray_S(0, row).z();  // for each metre along the axis
    const double ground_m = down > 0 ? kHeight_m / down : 1e9;
    for (int column = 0; column < picture.width; ++column) {
      ASSERT_NEAR(depths[static_cast<std::size_t>(row * picture.width + column)],
                  1000 * std::min(5.0, ground_m), 0.51)  // whole millimetres
          << "row " << row << ", column " << column;
    }
  }
}

TEST(DepthCamera, HasNoDepthWithoutAReturnAndTheMostBeyondItsFormat) {
  const DepthPicture picture{.width = 3, .height = 1, .focal_px = 2};
  LidarScan scan;
  scan.p_WS.setZero();
  scan.q_WS.setIdentity();
  scan.points.push_back(
      {.p_S = {70, 35, 0}, .p_W = {70, 35, 0}, .cosine = 1, .time_s = 0, .ring = 0});
  scan.points.push_back({.p_S = {1.2344F, -0.6172F, 0},
                         .p_W = {1.2344F, -0.6172F, 0},
                         .cosine = 1,
                         .time_s = 0,
                         .ring = 0});
  const std::string text = depth_text(scan, picture);
  EXPECT_THAT(text, testing::StartsWith("P5\n# viewpoint 0.000000 "));
  EXPECT_THAT(text, testing::HasSubstr("\n3 1\n65535\n"));
  EXPECT_THAT(depths_of(text, 3), testing::ElementsAre(65535, 0, 1234));
}

TEST(LidarPlugin, WritesThePicturesOfADepthCamera) {
  const cas::test::TemporaryFolder folder;
  cas::test::PluginHarness harness(milliseconds(4), folder.path());
  harness.world.body.p_WB = {0, 0, 3};
  const std::string keys =
      "rate_hz: 10, min_m: 0.3, max_m: 10, cloud: pgm, cloud_every: 1, "
      "mounting_rpy_deg: [0, 90, 0]}";
  harness.add("lidar", "{pattern: " + shipped_pattern("depth_camera").string() + ", " + keys);
  harness.run(milliseconds(200));
  const std::string text = bytes_of(folder.path() / "clouds/iris0_000001.pgm");
  ASSERT_GT(text.size(), 2U * 160 * 90);
  EXPECT_THAT(depths_of(text, 160U * 90U), testing::Each(3000)) << "the ground";
  EXPECT_THAT(cas::test::refusal([&] {
                harness.add("lidar",
                            "{pattern: " + shipped_pattern("vlp16").string() + ", " + keys);
              }),
              testing::HasSubstr("cloud: pgm needs the pattern of a depth camera"));
}

TEST(LidarPlugin, PublishesEachScanAndThatOfASecondLidar) {
  const cas::test::TemporaryFolder folder;
  cas::test::PluginHarness harness(milliseconds(4), folder.path());
  harness.world.body.p_WB = {1, 2, 3};
  std::ofstream(folder.path() / "down.csv")
      << "share,azimuth_deg,elevation_deg\n0,0,-90\n0.5,0,-30\n";
  const std::string yaml = "{pattern: " + (folder.path() / "down.csv").string() +
                           ", rate_hz: 20, min_m: 0.5, max_m: 100, position_B_m: [0, 0, -1]}";
  std::vector<std::uint64_t> numbers;
  std::vector<Subscription> taps;
  for (const char* topic : {"iris0/lidar", "iris0/lidar_2"}) {
    taps.push_back(harness.bus.subscribe<PointCloud>(topic, [&](const PointCloud& cloud) {
      numbers.push_back(cloud.number);
      EXPECT_EQ(cloud.p_WS, Eigen::Vector3d(1, 2, 2));
      ASSERT_EQ(cloud.points.size(), 2U);
      EXPECT_NEAR(cloud.points[1].p_S.z(), -2, kSinglePrecision_m);
    }));
  }
  harness.add("lidar", yaml);
  harness.add("lidar", yaml);
  harness.run(milliseconds(100));
  EXPECT_THAT(numbers, testing::ElementsAre(0, 0, 1, 1));
}

TEST(LidarPlugin, RefusesAFolderOutsideOfTheResults) {
  cas::test::PluginHarness harness;
  EXPECT_THAT(cas::test::refusal([&] {
                harness.add("lidar", "{pattern: " + shipped_pattern("vlp16").string() +
                                         ", rate_hz: 10, min_m: 0.5, max_m: 100, cloud: pcd, "
                                         "cloud_folder: ../x}");
              }),
              testing::HasSubstr("cloud_folder: '../x'"));
}

/// A sonar hears the nearest place of the ground in its cone, a laser the one on its axis.
TEST(RangefinderPlugin, HearsTheNearestSurfaceInItsCone) {
  cas::test::PluginHarness harness;
  harness.add("rangefinder",
              "{rate_hz: 50, stddev_m: 1.0e-6, min_m: 0.2, max_m: 40, beam_deg: 30}");
  RangeSample newest;
  const auto listening = harness.bus.subscribe<RangeSample>(
      "iris0/rangefinder", [&](const RangeSample& sample) { newest = sample; });
  const auto measure = [&](double roll_deg) {
    harness.world.body.p_WB.z() = 5;
    harness.world.body.q_WB = Eigen::AngleAxisd(roll_deg * base::kRadPerDeg, Vector3d::UnitX());
    harness.run(milliseconds(20));
    return newest.distance_m;
  };
  constexpr double kBetweenRays = 0.02;  // share of the distance
  EXPECT_NEAR(measure(0), 5, 1e-4);
  EXPECT_NEAR(measure(10), 5, 5 * kBetweenRays) << "straight down is in the cone";
  const double nearest = 5 / std::cos(45 * base::kRadPerDeg);
  EXPECT_NEAR(measure(60), nearest, nearest * 2 * kBetweenRays);
  EXPECT_GE(newest.distance_m, nearest - 1e-4);
  const auto packet = to_distance_sensor(newest);
  EXPECT_EQ(packet.type, mavlink::common::MavDistanceSensor::kUltrasound);
  EXPECT_NEAR(packet.horizontal_fov, 30 * base::kRadPerDeg, 1e-6);
}

}  // namespace
}  // namespace cas::sim

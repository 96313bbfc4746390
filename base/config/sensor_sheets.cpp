// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sensor_sheets.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>

#include "base/config/axes.hpp"
#include "base/config/config_keys.hpp"
#include "base/config/key_table.hpp"
#include "base/config/removed_keys.hpp"

namespace cas::base {
namespace {

using Eigen::Vector3d;

// Kinds of keys.

/// One number for all axes, or three.
struct Axes {
  static void read(const ConfigNode& node, Vector3d& value) { value = parse_axes(node); }
  static std::string text(const Vector3d& value) {
    if (value.isConstant(value.x(), 0)) return number_text(value.x());
    return "[" + number_text(value.x()) + ", " + number_text(value.y()) + ", " +
           number_text(value.z()) + "]";
  }
  static std::string values() { return "axes"; }
  static std::array<std::string, 2> samples() { return {"1", "[1, 2, 3]"}; }
};

/// Deviations.
struct Deviations : Axes {
  static void read(const ConfigNode& node, Vector3d& value) {
    Axes::read(node, value);
    if ((value.array() < 0.0).any()) node.fail("must not be negative");
  }
  static std::string values() { return "from 0, axes"; }
};

struct NoiseFigure : Axes {
  static void read(const ConfigNode& node, Vector3d& value) {
    Deviations::read(node, value);
    if ((value.array() == 0.0).any()) {
      node.fail("must be above zero: a flight controller takes values that repeat for stale");
    }
  }
  static std::string values() { return "above 0, axes"; }
};

struct ScaleError : Axes {
  static void read(const ConfigNode& node, Vector3d& value) {
    constexpr double kLargest = 0.5;
    Axes::read(node, value);
    if ((value.array().abs() > kLargest).any()) node.fail("is a fraction, at most 0.5");
  }
  static std::string values() { return "-0.5 to 0.5, axes"; }
};

struct Direction : Axes {
  static void read(const ConfigNode& node, Vector3d& value) {
    value = node.as<Vector3d>();
    if (value.norm() < 1e-6) node.fail("must not be zero");
    value.normalize();
  }
  static std::string values() { return "three numbers"; }
};

struct AboveZero : Number {
  static void read(const ConfigNode& node, double& value) {
    Number::read(node, value);
    if (value <= 0.0) node.fail("must be above zero");
  }
  static std::string values() { return "above 0"; }
};

/// Switched off by zero.
struct PositiveOrOff : Number {
  static void read(const ConfigNode& node, double& value) {
    Number::read(node, value);
    if (value < 0.0) node.fail("must not be negative (0 switches it off)");
  }
  static std::string values() { return "from 0"; }
};

/// Up to 16, from 0 to 10.
struct Fractions {
  static void read(const ConfigNode& node, std::vector<double>& values) {
    constexpr std::size_t kMost = 16;
    constexpr double kLargest = 10;
    values = node.as<std::vector<double>>();
    const bool in_range =
        std::ranges::all_of(values, [](double value) { return value >= 0 && value <= kLargest; });
    if (values.size() > kMost || !in_range) node.fail("must list up to 16 numbers from 0 to 10");
  }
  static std::string text(const std::vector<double>&) { return {}; }
  static std::string values() { return "list of numbers from 0 to 10"; }
  static std::array<std::string, 2> samples() { return {"[0.5]", "[0.5, 0.25]"}; }
};

constexpr double kMostSeconds = 1e6;

std::vector<GpsSheet::FixLoss> parse_fix_losses(const ConfigNode& node) {
  std::vector<GpsSheet::FixLoss> losses;
  for (const ConfigNode& item : node.items()) {
    const double from_s = item.require_in("from_s", 0.0, kMostSeconds);
    losses.push_back({from_s, item.require_in("to_s", from_s, kMostSeconds)});
  }
  return losses;
}

Eigen::Matrix3d parse_soft_iron(const ConfigNode& node) {
  const auto rows = node.as<std::vector<double>>();
  if (rows.size() != 9) node.fail("must list the 9 numbers of a 3x3 matrix, row by row");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

// Figures that each have a few keys.

constexpr std::string_view kOff = "off";
constexpr std::string_view kWhiteNoise = "white noise";
constexpr std::string_view kDrift = "drift";
constexpr std::string_view kWalk = "or a drift as a random walk";

struct NoiseNames {
  std::string_view stddev;
  std::string_view density;
};

template <auto... Steps>
constexpr auto noise_keys(const NoiseNames& names) {
  constexpr std::string_view kEither = "one of each two";
  return std::tuple{
      key<Steps..., &WhiteNoise::stddev>(names.stddev, NoiseFigure{}, kWhiteNoise, kEither),
      key<Steps..., &WhiteNoise::density>(names.density, NoiseFigure{}, kWhiteNoise, kEither)};
}

void check_noise(const ConfigNode& node, const NoiseNames& names, const WhiteNoise& noise) {
  const std::string stddev(names.stddev);
  if (noise.stddev && noise.density) {
    node.at(names.density).fail("is given beside " + stddev + "; white noise has one figure");
  }
  if (!noise.stddev && !noise.density) {
    node.fail("needs " + stddev + " or " + std::string(names.density));
  }
}

struct DriftNames {
  std::string_view walk;
  std::string_view walk_time;
  std::string_view stddev;
  std::string_view time;
};

template <auto... Steps>
constexpr auto drift_keys(const DriftNames& names) {
  return std::tuple{
      key<Steps..., &Drift::stddev>(names.stddev, Deviations{}, kDrift, kOff),
      key<Steps..., &Drift::time_constant_s>(names.time, AboveZero{}, kDrift, kOff),
      key<Steps..., &Drift::bias_walk>(names.walk, Deviations{}, kWalk, kOff),
      key<Steps..., &Drift::bias_time_constant_s>(names.walk_time, PositiveOrOff{}, kWalk, kOff)};
}

void check_drift(const ConfigNode& node, const DriftNames& names, const Drift& drift) {
  if (drift.bias_walk && drift.stddev) {
    node.at(names.stddev)
        .fail("is given beside " + std::string(names.walk) + "; drift has one figure");
  }
  const auto check_pair = [&node](bool figure, std::string_view name, std::string_view time) {
    if (figure) node.at(time);  // says that it is missing
    const auto given = node.find(time);
    if (given && !figure) given->fail("has no meaning without " + std::string(name));
  };
  check_pair(drift.bias_walk.has_value(), names.walk, names.walk_time);
  check_pair(drift.stddev.has_value(), names.stddev, names.time);
}

/// A value of every sheet.
template <auto Rate>
constexpr auto rate_key() {
  return required(key<Rate>("rate_hz", AboveZero{}, "at most the simulation's own rate"));
}

// imu

struct TriadNames {
  NoiseNames noise;
  DriftNames drift;
  std::string_view bias, turn_on_bias_stddev, scale_error, misalignment, range, lsb, vibration;
  std::string_view temperature, temperature_squared;
};

constexpr TriadNames kGyro{.noise = {"gyro_stddev_deg_s", "gyro_density_deg_s_per_sqrt_hz"},
                           .drift = {"gyro_bias_walk_deg_s_per_sqrt_s", "gyro_bias_time_constant_s",
                                     "gyro_drift_stddev_deg_s", "gyro_drift_time_constant_s"},
                           .bias = "gyro_bias_deg_s",
                           .turn_on_bias_stddev = "gyro_turn_on_bias_stddev_deg_s",
                           .scale_error = "gyro_scale_error",
                           .misalignment = "gyro_misalignment_deg",
                           .range = "gyro_range_deg_s",
                           .lsb = "gyro_lsb_deg_s",
                           .vibration = "gyro_vibration_deg_s",
                           .temperature = "gyro_temperature_deg_s_per_degc",
                           .temperature_squared = "gyro_temperature_deg_s_per_degc2"};
constexpr TriadNames kAccel{
    .noise = {"accel_stddev_m_s2", "accel_density_m_s2_per_sqrt_hz"},
    .drift = {"accel_bias_walk_m_s2_per_sqrt_s", "accel_bias_time_constant_s",
              "accel_drift_stddev_m_s2", "accel_drift_time_constant_s"},
    .bias = "accel_bias_m_s2",
    .turn_on_bias_stddev = "accel_turn_on_bias_stddev_m_s2",
    .scale_error = "accel_scale_error",
    .misalignment = "accel_misalignment_deg",
    .range = "accel_range_m_s2",
    .lsb = "accel_lsb_m_s2",
    .vibration = "accel_vibration_m_s2",
    .temperature = "accel_temperature_m_s2_per_degc",
    .temperature_squared = "accel_temperature_m_s2_per_degc2"};

template <auto Triad>
constexpr auto triad_keys(const TriadNames& names) {
  return std::tuple_cat(
      noise_keys<Triad, &TriadSheet::noise>(names.noise),
      std::tuple{key<Triad, &TriadSheet::bias>(names.bias, Axes{}, "the same in each run", kOff),
                 key<Triad, &TriadSheet::turn_on_bias_stddev>(
                     names.turn_on_bias_stddev, Deviations{},
                     "deviation of a bias that is drawn at the start of each run", kOff)},
      drift_keys<Triad, &TriadSheet::drift>(names.drift),
      std::tuple{
          key<Triad, &TriadSheet::scale_error>(names.scale_error, ScaleError{},
                                               "fraction of the measured value", kOff),
          key<Triad, &TriadSheet::misalignment_deg>(
              names.misalignment, Axes{}, "roll, pitch, yaw of the axes in the case", kOff),
          key<Triad, &TriadSheet::range>(names.range, PositiveOrOff{}, "clips beyond", kOff),
          key<Triad, &TriadSheet::lsb>(names.lsb, PositiveOrOff{}, "rounds to multiples", kOff),
          key<Triad, &TriadSheet::vibration>(names.vibration, Axes{},
                                             "amplitude per rotor at the reference speed", kOff),
          key<Triad, &TriadSheet::temperature>(
              names.temperature, Axes{}, "bias per degree above the calibration's temperature",
              kOff),
          key<Triad, &TriadSheet::temperature_squared>(names.temperature_squared, Axes{},
                                                       "and per its square", kOff)});
}

constexpr auto kImuKeys = std::tuple_cat(
    std::tuple{rate_key<&ImuSheet::rate_hz>()}, triad_keys<&ImuSheet::gyro>(kGyro),
    triad_keys<&ImuSheet::accel>(kAccel),
    std::tuple{
        key<&ImuSheet::gyro_g_sensitivity_deg_s_per_m_s2>(
            "gyro_g_sensitivity_deg_s_per_m_s2", Axes{},
            "rate that specific force along the axis adds", kOff),
        key<&ImuSheet::vibration_reference_rad_s>("vibration_reference_rad_s", PositiveOrOff{},
                                                  "rotor speed of the vibration's amplitudes",
                                                  "with a vibration"),
        key<&ImuSheet::vibration_harmonics>(
            "vibration_harmonics", Fractions{},
            "of the 2nd, 3rd, ... multiple of a rotor's frequency, fraction of the first", kOff),
        key<&ImuSheet::vibration_imbalance>("vibration_imbalance", Fractions{},
                                            "factor of each rotor", "1 each"),
        key<&ImuSheet::start_degc>("start_degc", Range{-100, 100},
                                   "temperature at the start, above that of the calibration"),
        key<&ImuSheet::warm_up_degc>("warm_up_degc", Range{-100, 100},
                                     "by which it rises in the end", kOff),
        key<&ImuSheet::warm_up_time_constant_s>("warm_up_time_constant_s", AboveZero{},
                                                "of that rise", "with a warm-up"),
        key<&ImuSheet::position_B_m>("position_B_m", Axes{}, "from the centre of gravity"),
        key<&ImuSheet::mounting_rpy_deg>("mounting_rpy_deg", Axes{},
                                         "roll, pitch, yaw of the case")});

// gps

constexpr NoiseNames kPosition{"position_stddev_m", "position_density_m_per_sqrt_hz"};
constexpr NoiseNames kVelocity{"velocity_stddev_m_s", "velocity_density_m_s_per_sqrt_hz"};
constexpr DriftNames kPositionDrift{"position_bias_walk_m_per_sqrt_s",
                                    "position_bias_time_constant_s", "position_drift_stddev_m",
                                    "position_drift_time_constant_s"};
constexpr double kMostMetres = 600;  // the wire's 16 bits of centimetres

constexpr auto kGpsKeys = std::tuple_cat(
    std::tuple{
        rate_key<&GpsSheet::rate_hz>(),
        key<&GpsSheet::delay_s>("delay_s", Range{0, 10},
                                "from measurement to publication; the stamp is the measurement's")},
    noise_keys<&GpsSheet::position>(kPosition),
    drift_keys<&GpsSheet::position_drift>(kPositionDrift),
    noise_keys<&GpsSheet::velocity>(kVelocity),
    std::tuple{
        required(key<&GpsSheet::eph_m>("eph_m", Range{0, kMostMetres},
                                       "reported accuracy of the horizontal position, 1 sigma")),
        required(key<&GpsSheet::epv_m>("epv_m", Range{0, kMostMetres}, "that of the altitude")),
        required(key<&GpsSheet::satellites>("satellites", Whole{0, 64}, "reported")),
        key<&GpsSheet::first_fix_s>("first_fix_s", Range{0, kMostSeconds}, "no fix before"),
        key<&GpsSheet::fix_losses>("fix_losses", Parsed<parse_fix_losses>{},
                                   "list of `{from_s, to_s}`: no fix between"),
        key<&GpsSheet::antenna_B_m>("antenna_B_m", Axes{}, "from the centre of gravity"),
        key<&GpsSheet::earth_model>(
            "earth_model",
            Words<EarthModel, 2>{{{{"sphere", EarthModel::kSphere}, {"wgs84", EarthModel::kWgs84}}},
                                 "must be sphere or wgs84"},
            "`sphere`: Eq. (5)", "the world's")});

// magnetometer, barometer, rangefinder, lidar, airspeed

constexpr NoiseNames kField{"stddev_gauss", "density_gauss_per_sqrt_hz"};
constexpr DriftNames kFieldDrift{"bias_walk_gauss_per_sqrt_s", "bias_time_constant_s",
                                 "drift_stddev_gauss", "drift_time_constant_s"};

constexpr auto kMagnetometerKeys = std::tuple_cat(
    std::tuple{rate_key<&MagnetometerSheet::rate_hz>()},
    noise_keys<&MagnetometerSheet::noise>(kField),
    drift_keys<&MagnetometerSheet::drift>(kFieldDrift),
    std::tuple{
        key<&MagnetometerSheet::hard_iron_gauss>("hard_iron_gauss", Axes{},
                                                 "field of the vehicle itself", kOff),
        key<&MagnetometerSheet::soft_iron>("soft_iron", Parsed<parse_soft_iron>{},
                                           "matrix on the field, 9 numbers row by row"),
        key<&MagnetometerSheet::lsb_gauss>("lsb_gauss", Range{0, 1}, "rounds to multiples", kOff)});

constexpr NoiseNames kPressure{"stddev_pa", "density_pa_per_sqrt_hz"};
constexpr DriftNames kPressureDrift{"bias_walk_pa_per_sqrt_s", "bias_time_constant_s",
                                    "drift_stddev_pa", "drift_time_constant_s"};

constexpr auto kBarometerKeys = std::tuple_cat(
    std::tuple{rate_key<&BarometerSheet::rate_hz>()}, noise_keys<&BarometerSheet::noise>(kPressure),
    drift_keys<&BarometerSheet::drift>(kPressureDrift),
    std::tuple{
        key<&BarometerSheet::self_heating_degc>("self_heating_degc", Range{-50, 100},
                                                "of the sensor against the air"),
        key<&BarometerSheet::wind_pressure_coefficient>(
            "wind_pressure_coefficient", Range{-2, 2},
            "share of the dynamic pressure in the reading"),
        key<&BarometerSheet::lsb_pa>("lsb_pa", Range{0, 1000}, "rounds to multiples", kOff)});

constexpr NoiseNames kDistance{"stddev_m", "density_m_per_sqrt_hz"};
constexpr double kFarthest_m = 10'000;

constexpr auto kRangefinderKeys = std::tuple_cat(
    std::tuple{rate_key<&RangefinderSheet::rate_hz>()},
    noise_keys<&RangefinderSheet::noise>(kDistance),
    std::tuple{
        required(key<&RangefinderSheet::min_m>("min_m", Range{0, kFarthest_m},
                                               "a nearer reading is invalid")),
        required(key<&RangefinderSheet::max_m>("max_m", Range{0, kFarthest_m},
                                               "a farther one; not below `min_m`")),
        key<&RangefinderSheet::lsb_m>("lsb_m", Range{0, 10}, "rounds to multiples", kOff),
        key<&RangefinderSheet::position_B_m>("position_B_m", Axes{}, "from the centre of gravity"),
        key<&RangefinderSheet::direction_B>("direction_B", Direction{}, "of its ray"),
        key<&RangefinderSheet::beam_deg>("beam_deg", Range{0, 120},
                                         "width of a cone (sonar), of which the nearest surface "
                                         "counts; 0: a ray")});

constexpr auto kLidarKeys = std::tuple{
    required(key<&LidarSheet::pattern>(
        "pattern", Text{}, "file of its beams or pixels: `../lidars/vlp16.yaml`, or a CSV file")),
    required(key<&LidarSheet::rate_hz>("rate_hz", AboveZero{},
                                       "scans (turns) in a second, at most the simulation's rate")),
    required(key<&LidarSheet::min_m>("min_m", Range{0, kFarthest_m},
                                     "a nearer surface gives no return")),
    required(key<&LidarSheet::max_m>("max_m", Range{0, kFarthest_m},
                                     "a farther one; not below `min_m`")),
    key<&LidarSheet::stddev_m>("stddev_m", Range{0, 10}, "white noise of a distance", kOff),
    key<&LidarSheet::dropout>("dropout", Range{0, 1}, "share of the beams that are lost", kOff),
    key<&LidarSheet::max_incidence_deg>("max_incidence_deg", Range{0, 90},
                                        "a beam farther from the surface's normal gives no return"),
    key<&LidarSheet::position_B_m>("position_B_m", Axes{}, "from the centre of gravity"),
    key<&LidarSheet::mounting_rpy_deg>("mounting_rpy_deg", Axes{}, "roll, pitch, yaw of the case"),
    key<&LidarSheet::obstacle_height_m>(
        "obstacle_height_m", Range{0, kFarthest_m},
        "sends OBSTACLE_DISTANCE after each scan: surfaces at most so far above or below the "
        "sensor count"),
    key<&LidarSheet::cloud>(
        "cloud",
        Words<CloudForm, 3>{
            {{{"pcd", CloudForm::kPcd}, {"ply", CloudForm::kPly}, {"pgm", CloudForm::kPgm}}}},
        "writes scans as files of this format; `pgm`: pictures of a depth camera"),
    key<&LidarSheet::cloud_every>("cloud_every", Whole{1, 1'000'000}, "the first of so many scans"),
    key<&LidarSheet::cloud_folder>("cloud_folder", Text{},
                                   "of the files, below the folder of the results")};

// Names of noise and drift are the barometer's: both are pressures.
constexpr auto kAirspeedKeys = std::tuple_cat(
    std::tuple{rate_key<&AirspeedSheet::rate_hz>()}, noise_keys<&AirspeedSheet::noise>(kPressure),
    drift_keys<&AirspeedSheet::drift>(kPressureDrift),
    std::tuple{
        key<&AirspeedSheet::bias_pa>("bias_pa", Range{-1000, 1000}, "the same in each run", kOff),
        key<&AirspeedSheet::position_error>(
            "position_error", Range{-0.5, 0.5},
            "fraction that the place of the tube adds to the dynamic pressure", kOff),
        key<&AirspeedSheet::lag_s>("lag_s", Range{0, 10}, "time constant of hoses and filter",
                                   kOff),
        key<&AirspeedSheet::position_B_m>("position_B_m", Axes{}, "from the centre of gravity"),
        key<&AirspeedSheet::direction_B>("direction_B", Direction{}, "of the tube")});

// odometry

constexpr NoiseNames kAttitude{"attitude_stddev_deg", "attitude_density_deg_per_sqrt_hz"};
constexpr NoiseNames kRate{"rate_stddev_deg_s", "rate_density_deg_s_per_sqrt_hz"};

/// Keys of fields that VISION_POSITION_ESTIMATE lacks.
constexpr std::array<std::string_view, 3> kOdometryAlone{"frame", "estimator_type", "quality"};

constexpr auto kOdometryKeys = std::tuple_cat(
    std::tuple{rate_key<&OdometrySheet::rate_hz>(),
               key<&OdometrySheet::delay_s>("delay_s", Range{0, 5},
                                            "from measurement to publication; the stamp is the "
                                            "measurement's")},
    noise_keys<&OdometrySheet::position>(kPosition),
    noise_keys<&OdometrySheet::attitude>(kAttitude),
    noise_keys<&OdometrySheet::velocity>(kVelocity), noise_keys<&OdometrySheet::rate>(kRate),
    std::tuple{
        key<&OdometrySheet::position_walk>("position_walk_m_per_sqrt_s", Deviations{},
                                           "drift of the position: a random walk", kOff),
        key<&OdometrySheet::yaw_walk>("yaw_walk_deg_per_sqrt_s", PositiveOrOff{},
                                      "and of the heading, which turns what is flown from then on",
                                      kOff),
        key<&OdometrySheet::origin_N_m>("origin_N_m", Axes{},
                                        "of its frame, north, east and down of the world's"),
        key<&OdometrySheet::heading_deg>("heading_deg", Range{-360, 360},
                                         "of its frame's x axis, clockwise from north"),
        key<&OdometrySheet::position_B_m>("position_B_m", Axes{}, "from the centre of gravity"),
        key<&OdometrySheet::message>(
            "message",
            Words<OdometryMessage, 2>{
                {{{"ODOMETRY", OdometryMessage::kOdometry},
                  {"VISION_POSITION_ESTIMATE", OdometryMessage::kVisionPositionEstimate}}}},
            "that the controller gets"),
        key<&OdometrySheet::frame>(
            "frame",
            Words<OdometryFrame, 2>{{{{"LOCAL_FRD", OdometryFrame::kLocalFrd},
                                      {"LOCAL_NED", OdometryFrame::kLocalNed}}}},
            "`frame_id` of ODOMETRY: what its frame is called, whatever `heading_deg` is"),
        key<&OdometrySheet::estimator_type>(
            "estimator_type",
            Words<OdometryKind, 6>{{{{"VIO", OdometryKind::kVio},
                                     {"VISION", OdometryKind::kVision},
                                     {"MOCAP", OdometryKind::kMocap},
                                     {"LIDAR", OdometryKind::kLidar},
                                     {"NAIVE", OdometryKind::kNaive},
                                     {"UNKNOWN", OdometryKind::kUnknown}}}},
            "of ODOMETRY"),
        key<&OdometrySheet::quality>("quality", Whole{-1, 100},
                                     "of ODOMETRY, %: -1 has failed, 0 is unknown")});

template <class Sheet, class Keys>
Sheet read_sheet(const ConfigNode& node, const Keys& keys) {
  Sheet sheet;
  read_keys(node, keys, sheet);
  return sheet;
}

/// Keys of one meaning, like the two of a drift or those of both triads, share a row.
std::vector<KeyRow> joined(const std::vector<KeyRow>& rows) {
  std::vector<KeyRow> joined;
  for (const KeyRow& row : rows) {
    const auto same = std::ranges::find(joined, row.help, &KeyRow::help);
    if (same == joined.end()) {
      joined.push_back(row);
    } else {
      same->key += "`, `" + row.key;
    }
  }
  return joined;
}

/// @param truth  description of the measured quantity
template <class Sheet, class Keys>
std::string section(const std::string& sensor, const std::string& truth, const Keys& keys) {
  std::vector<KeyRow> rows;
  add_rows(keys, Sheet{}, rows);
  return "### " + sensor + "\n\n" + truth + "\n\n" + key_table(joined(rows));
}

}  // namespace

ImuSheet read_imu_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<ImuSheet>(node, kImuKeys);
  check_noise(node, kGyro.noise, sheet.gyro.noise);
  check_drift(node, kGyro.drift, sheet.gyro.drift);
  check_noise(node, kAccel.noise, sheet.accel.noise);
  check_drift(node, kAccel.drift, sheet.accel.drift);
  const bool vibrates = !sheet.gyro.vibration.isZero(0.0) || !sheet.accel.vibration.isZero(0.0);
  if (vibrates && sheet.vibration_reference_rad_s <= 0.0) {
    node.fail("gives a vibration amplitude without vibration_reference_rad_s");
  }
  if (sheet.warm_up_degc != 0) node.at("warm_up_time_constant_s");  // says that it is missing
  return sheet;
}

GpsSheet read_gps_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<GpsSheet>(node, kGpsKeys);
  check_noise(node, kPosition, sheet.position);
  check_drift(node, kPositionDrift, sheet.position_drift);
  check_noise(node, kVelocity, sheet.velocity);
  return sheet;
}

MagnetometerSheet read_magnetometer_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<MagnetometerSheet>(node, kMagnetometerKeys);
  check_noise(node, kField, sheet.noise);
  check_drift(node, kFieldDrift, sheet.drift);
  return sheet;
}

BarometerSheet read_barometer_sheet(const ConfigNode& node) {
  constexpr const char* kNow = "the air of the day is `weather` of the scenario or simulation";
  refuse_removed(node, {{"qnh_hpa", kNow}, {"temperature_offset_degc", kNow}});
  const auto sheet = read_sheet<BarometerSheet>(node, kBarometerKeys);
  check_noise(node, kPressure, sheet.noise);
  check_drift(node, kPressureDrift, sheet.drift);
  return sheet;
}

RangefinderSheet read_rangefinder_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<RangefinderSheet>(node, kRangefinderKeys);
  check_noise(node, kDistance, sheet.noise);
  if (sheet.max_m < sheet.min_m) node.at("max_m").fail("must not be below min_m");
  return sheet;
}

LidarSheet read_lidar_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<LidarSheet>(node, kLidarKeys);
  if (sheet.max_m < sheet.min_m) node.at("max_m").fail("must not be below min_m");
  return sheet;
}

AirspeedSheet read_airspeed_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<AirspeedSheet>(node, kAirspeedKeys);
  check_noise(node, kPressure, sheet.noise);
  check_drift(node, kPressureDrift, sheet.drift);
  return sheet;
}

OdometrySheet read_odometry_sheet(const ConfigNode& node) {
  const auto sheet = read_sheet<OdometrySheet>(node, kOdometryKeys);
  check_noise(node, kPosition, sheet.position);
  check_noise(node, kAttitude, sheet.attitude);
  check_noise(node, kVelocity, sheet.velocity);
  check_noise(node, kRate, sheet.rate);
  if (sheet.message == OdometryMessage::kOdometry) return sheet;
  for (const std::string_view name : kOdometryAlone) {
    if (const auto key = node.find(name)) key->fail("has no field in VISION_POSITION_ESTIMATE");
  }
  return sheet;
}

std::string sensor_reference() {
  return section<ImuSheet>("imu",
                           "Truth is the mean over the sample period. At rest and level, the "
                           "accelerometer reads +g along Bz: (0, 0, -g) on the wire.",
                           kImuKeys) +
         "\n" +
         section<GpsSheet>("gps",
                           "Truth is the antenna's place and velocity; axes are north, east, down.",
                           kGpsKeys) +
         "\n" +
         section<MagnetometerSheet>(
             "magnetometer",
             "Truth is the World Magnetic Model's field at place and date, or "
             "the world's [`<magnetic_field>`](simulator.md#worlds).",
             kMagnetometerKeys) +
         "\n" +
         section<BarometerSheet>("barometer",
                                 "Truth is the standard atmosphere, or the world's "
                                 "[`<atmosphere>`](simulator.md#worlds), on the day of "
                                 "[`weather`](../reference/config.md#weather).",
                                 kBarometerKeys) +
         "\n" +
         section<RangefinderSheet>("rangefinder", "Truth is the length of a ray into the world.",
                                   kRangefinderKeys) +
         "\n" +
         section<LidarSheet>("lidar",
                             "Truth is the length of each beam's ray into the world, from where "
                             "the sensor is when the beam fires.",
                             kLidarKeys) +
         "\n" +
         section<AirspeedSheet>("airspeed",
                                "Truth is the dynamic pressure 1/2 rho u\\|u\\| of the air that "
                                "meets the tube: density and wind are those at the vehicle.",
                                kAirspeedKeys) +
         "\n" +
         section<OdometrySheet>("odometry",
                                "Truth is place, attitude, velocity and rates of the point "
                                "`position_B_m`, in the frame that `origin_N_m` and `heading_deg` "
                                "give.",
                                kOdometryKeys);
}

}  // namespace cas::base

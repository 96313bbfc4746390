// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "libsim/api/fault_order.hpp"
#include "plugins/fault/expression.hpp"
#include "plugins/fault/fault_spec.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/plugins/statistics.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(ExpressionOnFacts, IsTrueOrNot) {
  struct ExpressionCase {
    const char* text;
    bool expected;  // at altitude 3, time 10, speed 0, armed, phase hold
  };
  const ExpressionCase rows[] = {{"altitude > 2 and phase == hold", true},
                                 {"altitude > 2 and phase == land", false},
                                 {"phase != land", true},
                                 {"speed > 1 and speed > 2 or altitude >= 3", true},
                                 {"speed > 1 and (speed > 2 or altitude >= 3)", false},
                                 {"not altitude < 2", true},
                                 {"armed", true},
                                 {"not armed", false},
                                 {"yaw < -89.5", true},
                                 {"2 < altitude", true},
                                 {"time == 10", true},
                                 {"altitude>2 and time>=1e1", true}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.text);
    Facts facts;
    facts[Fact::kAltitude] = 3;
    facts[Fact::kTime] = 10;
    facts[Fact::kArmed] = 1;
    facts[Fact::kYaw] = -90;
    facts.phase = "hold";
    EXPECT_EQ(Expression::parse(row.text).evaluate(facts), row.expected);
  }
}

TEST(Expression, RefusesWhatItDoesNotUnderstand) {
  for (const char* text :
       {"", "altitude >", "altitude > 2 and", "(altitude > 2", "altitud > 2", "altitude > 2 )",
        "phase > hold", "phase ==", "altitude > 2 2", "altitude >> 2", "5", "-1", "2 > 1",
        "altitude", "armed and 1", "not speed"}) {
    EXPECT_THROW(Expression::parse(text), std::invalid_argument) << text;
  }
}

TEST(Expression, RefusesNumbersThatAreNotFinite) {
  for (const char* text : {"altitude > nan", "altitude < inf", "-inf < climb", "nan",
                           "time > 1e999", "infinity > time", "yaw == nan(1)"}) {
    EXPECT_THAT([&] { Expression::parse(text); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("'")))
        << text;
  }
  EXPECT_THAT(
      [] { Expression::parse("altitude > nan"); },
      ThrowsMessage<std::invalid_argument>("in 'altitude > nan': 'nan' is not a finite number"));
}

std::string repeated(std::string_view text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

TEST(Expression, CountsItsLevels) {
  EXPECT_NO_THROW(Expression::parse(repeated("(", 64) + "armed" + repeated(")", 64)));
  EXPECT_NO_THROW(Expression::parse(repeated("(armed) and ", 100) + "armed"));  // side by side
  for (const std::size_t deep : {65U, 200'000U}) {
    EXPECT_THROW(Expression::parse(repeated("(", deep) + "armed" + repeated(")", deep)),
                 std::invalid_argument);
    EXPECT_THROW(Expression::parse(repeated("not ", deep) + "armed"), std::invalid_argument);
  }
}

TEST(Expression, CountsItsTerms) {
  Facts facts;
  facts[Fact::kArmed] = 1;
  EXPECT_TRUE(Expression::parse(repeated("armed and ", 400) + "armed").evaluate(facts));
  EXPECT_THROW(Expression::parse(repeated("armed and ", 100'000) + "armed"), std::invalid_argument);
}

TEST(FaultSpec, RefusesHalfAndDoubleEntries) {
  for (const char* yaml :
       {"faults: [{at_s: 1}]",
        "faults: [{freeze: imu}]",
        "faults: [{at_s: 1, when: armed, freeze: imu}]",
        "faults: [{at_s: 1, freeze: imu, drop: gps}]",
        "faults: [{at_s: 1, freeze: sonar}]",
        "faults: [{at_s: 1, bias: {sensor: imu}}]",
        "faults: [{at_s: 1, rotor: {number: 17}}]",
        "faults: [{at_s: 1, for_s: 1, until: armed, freeze: imu}]",
        "faults: [{when: 'altitud > 2', freeze: imu}]",
        "faults: [{at_s: 1, clip: {sensor: imu, angular_rate_deg_s: -1}}]",
        "faults: [{at_s: 1, axes: {sensor: imu, from: [x, y]}}]",
        "faults: [{at_s: 1, axes: {sensor: gps, from: [x, y, z]}}]",
        "faults: [{at_s: 1, axes: {sensor: imu, from: [x, y, w]}}]",
        "faults: [{at_s: 1, turn: {sensor: barometer, rpy_deg: [0, 0, 1]}}]",
        "faults: [{at_s: 1, current: {sensor: gps, position_m: 1}}]",
        "faults: [{at_s: 1, airflow: {sensor: imu, pressure_coefficient: 1}}]",
        "faults: [{at_s: 1, swap_rotors: [1]}]",
        "faults: [{at_s: 1, jammed: {sensor: imu, jammer_to_noise_db: 1}}]",
        "faults: [{at_s: 1, multipath: {position_m: -1, time_constant_s: 1}}]",
        "faults: [{at_s: 1, vibration: {sensor: gps, position_m: 1}}]",
        "faults: [{at_s: 1, blind: imu}]",
        "faults: [{at_s: 1, surface: {stuck: true}}]",
        "faults: [{at_s: 1, surface: {name: elevator}}]",
        "faults: [{at_s: 1, surface: {name: elevator, number: 1, stuck: true}}]",
        "faults: [{at_s: 1, surface: {name: elevator, dead: true, reversed: true}}]",
        "faults: [{at_s: 1, surface: {name: elevator, stuck_deg: 91}}]",
        "faults: [{at_s: 1, surface: {number: 17, dead: true}}]",
        "faults: [{at_s: 1, rotor: {number: 1, stop: true, stuck: true}}]"}) {
    EXPECT_THROW(parse_faults(base::ConfigNode::parse(yaml)), base::ConfigError) << yaml;
  }
}

TEST(FaultPlugin, RefusesARotorThatTheVehicleLacks) {
  test::PluginHarness quad;
  EXPECT_THROW(quad.add("fault", "{faults: [{at_s: 1, rotor: {number: 5, stop: true}}]}"),
               base::ConfigError);
  test::PluginHarness hexa(std::chrono::milliseconds(1), ".", "hexa_x");
  EXPECT_NO_THROW(hexa.add("fault", "{faults: [{at_s: 1, rotor: {number: 6, stop: true}}]}"));
}

struct MissingSurface {
  const char* fault;
  const char* sentence;
};

TEST(FaultPlugin, RefusesASurfaceThatTheVehicleLacks) {
  const base::Vehicle plane = test::load_vehicle("plane");
  const base::Vehicle quad = test::load_vehicle("iris_px4");
  const auto missing = [](const char* fault, const base::Vehicle& vehicle) {
    const auto node = base::ConfigNode::parse(fault, "fault");
    return missing_part(parse_fault(node, 1).kind, vehicle);
  };
  for (const auto& [fault, sentence] :
       {MissingSurface{"{at_s: 1, surface: {name: elevator, stuck_deg: -57}}", ""},
        MissingSurface{"{at_s: 1, surface: {number: 6, dead: true}}", ""},
        MissingSurface{"{at_s: 1, surface: {name: tail, dead: true}}",
                       "there is no surface 'tail'; vehicle 'plane' has rudder, flap_left, "
                       "aileron_left, aileron_right, elevator, flap_right"},
        MissingSurface{"{at_s: 1, surface: {number: 7, dead: true}}",
                       "there is no surface 7; vehicle 'plane' has rudder, flap_left, "
                       "aileron_left, aileron_right, elevator, flap_right"},
        MissingSurface{"{at_s: 1, surface: {name: rudder, stuck_deg: 60}}",
                       "surface 'rudder' of vehicle 'plane' turns from -57.2958 to 57.2958 deg, "
                       "not to 60"}}) {
    EXPECT_EQ(missing(fault, plane), sentence) << fault;
  }
  EXPECT_EQ(missing("{at_s: 1, surface: {number: 1, dead: true}}", quad),
            "there is no surface 1; vehicle 'iris_px4' has none");
  test::PluginHarness harness;
  EXPECT_THROW(harness.add("fault", "{faults: [{at_s: 1, surface: {number: 1, dead: true}}]}"),
               base::ConfigError);
}

/// A vehicle with an IMU and a barometer whose faults are `yaml`; samples by time of arrival.
class FaultyVehicle : public testing::Test {
 protected:
  struct Arrived {
    base::SimTime at;
    BarometerSample sample;
  };

  void start(const std::string& faults, bool with_fault_first = false) {
    if (with_fault_first) plugin_ = &harness_.add("fault", faults);
    harness_.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 1.0e-6, accel_stddev_m_s2: 1.0e-6}");
    harness_.add("barometer", "{rate_hz: 50, stddev_pa: 1.0e-3}");
    if (!with_fault_first) plugin_ = &harness_.add("fault", faults);
    barometer_ =
        harness_.bus.subscribe<BarometerSample>("iris0/barometer", [this](const auto& sample) {
          pressures_.push_back({now_, sample});
        });
    imu_ = harness_.bus.subscribe<ImuSample>("iris0/imu",
                                             [this](const ImuSample& s) { imus_.push_back(s); });
  }
  void run(base::Duration time) {
    for (base::Duration done{}; done < time; done += milliseconds(1)) {
      now_ += milliseconds(1);
      harness_.step();
    }
  }

  /// Gives orders over a topic.
  auto orders(const std::string& topic) {
    return [to = harness_.bus.advertise<FaultOrder>("iris0/" + topic)](const std::string& script) {
      FaultOrder message;
      std::ranges::copy(script, message.script.begin());
      to.publish(message);
    };
  }

  test::PluginHarness harness_;
  Plugin* plugin_ = nullptr;
  base::SimTime now_;
  std::vector<Arrived> pressures_;
  std::vector<ImuSample> imus_;
  Subscription barometer_;
  Subscription imu_;
};

TEST_F(FaultyVehicle, DropsSamplesForAWhile) {
  start("{faults: [{at_s: 0.5, for_s: 0.2, drop: barometer}]}");
  run(seconds(1));
  EXPECT_EQ(pressures_.size(), 40U);
  EXPECT_EQ(imus_.size(), 500U);  // the others do not notice
}

TEST_F(FaultyVehicle, FreezesAValueWhileItsStampGoesOn) {
  start("{faults: [{at_s: 0.5, for_s: 0.2, freeze: barometer}]}", true);
  run(seconds(1));
  ASSERT_EQ(pressures_.size(), 50U);
  const double frozen = pressures_[24].sample.pressure_pa;  // 0.5 s
  for (std::size_t i = 25; i < 35; ++i) {
    EXPECT_EQ(pressures_[i].sample.pressure_pa, frozen);
    EXPECT_EQ(pressures_[i].sample.time, pressures_[i].at);
  }
  EXPECT_NE(pressures_[35].sample.pressure_pa, frozen);
}

TEST_F(FaultyVehicle, DelaysExactlyAndKeepsTheOrder) {
  start("{faults: [{at_s: 0.1, for_s: 0.3, delay: {sensor: barometer, by_s: 0.05}}]}");
  run(seconds(1));
  ASSERT_EQ(pressures_.size(), 50U);
  for (std::size_t i = 0; i < pressures_.size(); ++i) {
    const auto& [at, sample] = pressures_[i];
    EXPECT_EQ(sample.time.time_since_epoch(), milliseconds(20 * (i + 1)));
    const bool late = sample.time > base::SimTime(milliseconds(100)) &&
                      sample.time <= base::SimTime(milliseconds(400));
    const base::Duration delay = at - sample.time;
    // Samples after the fault's end wait until delayed ones have gone.
    EXPECT_GE(delay, late ? milliseconds(50) : milliseconds(0)) << i;
    EXPECT_LE(delay, late ? milliseconds(50) : milliseconds(30)) << i;
  }
}

TEST_F(FaultyVehicle, BiasesAndScalesInTheUnitsOfTheKeys) {
  start(
      "{faults: [{at_s: 0.1, for_s: 0.1, bias: {sensor: imu, angular_rate_deg_s: [90, 0, 0]}}, "
      "{at_s: 0.3, scale: {sensor: imu, specific_force: [1, 1, 2]}}]}");
  run(milliseconds(500));
  constexpr double kNoise = 1e-4;
  EXPECT_NEAR(imus_[40].angular_rate_B.x(), 0, kNoise);
  EXPECT_NEAR(imus_[70].angular_rate_B.x(), M_PI / 2, kNoise);
  EXPECT_NEAR(imus_[120].angular_rate_B.x(), 0, kNoise);
  EXPECT_NEAR(imus_[70].specific_force_B.z(), test::kGravity, kNoise);
  EXPECT_NEAR(imus_[200].specific_force_B.z(), 2 * test::kGravity, kNoise);
}

TEST_F(FaultyVehicle, DriftsByTheTimeSinceItBegan) {
  start("{faults: [{at_s: 0.1, drift: {sensor: barometer, pressure_pa_s: 1000}}]}");
  run(seconds(1));
  const double before = pressures_[4].sample.pressure_pa;  // 0.1 s: nothing has drifted yet
  constexpr double kNoise = 0.02;
  for (std::size_t i = 5; i < pressures_.size(); ++i) {
    // It began in the step that ended at 0.101 s.
    const double since_s = base::to_seconds(pressures_[i].at.time_since_epoch()) - 0.101;
    EXPECT_NEAR(pressures_[i].sample.pressure_pa - before, 1000 * since_s, kNoise) << i;
  }
}

TEST_F(FaultyVehicle, ClipsAtTheEndOfTheRange) {
  start(
      "{faults: [{at_s: 0.1, clip: {sensor: imu, specific_force_m_s2: 4}}, "
      "{at_s: 0.1, bias: {sensor: imu, angular_rate_deg_s: [90, -90, 1]}}, "
      "{at_s: 0.2, clip: {sensor: imu, angular_rate_deg_s: [180, 45, 45]}}]}");
  run(milliseconds(300));
  EXPECT_NEAR(imus_[40].specific_force_B.z(), test::kGravity, 1e-4);
  EXPECT_EQ(imus_[80].specific_force_B.z(), 4);
  EXPECT_NEAR(imus_[140].angular_rate_B.x(), M_PI / 2, 1e-4);
  EXPECT_EQ(imus_[140].angular_rate_B.y(), -M_PI / 4);
  EXPECT_NEAR(imus_[140].angular_rate_B.z(), M_PI / 180, 1e-4);
}

TEST_F(FaultyVehicle, TurnsAndExchangesTheAxesOfASensor) {
  harness_.world.body.w_WB_B = {0.1, 0.2, 0.3};
  start(
      "{faults: [{at_s: 0.1, for_s: 0.1, turn: {sensor: imu, rpy_deg: [0, 0, 90]}}, "
      "{at_s: 0.3, axes: {sensor: imu, from: [y, -x, z]}}]}");
  run(milliseconds(400));
  constexpr double kNoise = 1e-4;
  EXPECT_TRUE(imus_[40].angular_rate_B.isApprox(Vector3d(0.1, 0.2, 0.3), kNoise));
  // The sensor's nose points to the right: along it, it reads the vehicle's rate about -y of B, and
  // to its left the rate about the vehicle's forward axis.
  EXPECT_TRUE(imus_[80].angular_rate_B.isApprox(Vector3d(-0.2, 0.1, 0.3), kNoise));
  EXPECT_TRUE(imus_[180].angular_rate_B.isApprox(Vector3d(0.2, -0.1, 0.3), kNoise));
}

TEST_F(FaultyVehicle, PressureErrsWithTheAirThatMeetsIt) {
  harness_.world.body.v_WB = {10, 0, 0};
  start("{faults: [{at_s: 0.5, airflow: {sensor: barometer, pressure_coefficient: -0.5}}]}");
  run(seconds(1));
  // -0.5 * 1/2 * 1.225 kg/m^3 * (10 m/s)^2
  EXPECT_NEAR(pressures_[40].sample.pressure_pa - pressures_[10].sample.pressure_pa, -30.625, 0.02);
}

TEST(FaultPlugin, MagnetometerErrsWithThePowerOfTheRotors) {
  test::PluginHarness harness;
  const auto speeds = harness.bus.advertise<RotorSpeeds>("iris0/rotor_speeds");
  const auto field = harness.bus.advertise<MagnetometerSample>("iris0/magnetometer");
  harness.add("fault",
              "{faults: [{at_s: 0, current: {sensor: magnetometer, field_gauss: [0, 0.2, 0]}}]}");
  const test::Heard<MagnetometerSample> heard(harness, "magnetometer");
  const MagnetometerSample& read = heard.newest;
  harness.step();
  const auto measured = [&](double share) {
    const base::Vehicle vehicle = test::load_vehicle("iris_paper");
    const double hover = std::sqrt(vehicle.mass_kg * test::kGravity / 4 /
                                   vehicle.rotors.front().params.thrust_coefficient);
    RotorSpeeds now;
    now.omega_rad_s.setConstant(4, share * hover);
    speeds.publish(now);
    harness.step();
    field.publish({.time = {}, .field_B_gauss = {0.1, 0.1, 0.1}});
    return read.field_B_gauss.y();
  };
  EXPECT_NEAR(measured(1.0), 0.1 + 0.2, 1e-9);
  EXPECT_NEAR(measured(2.0), 0.1 + 8 * 0.2, 1e-9);  // power goes with the speed's cube
  EXPECT_NEAR(measured(0.0), 0.1, 1e-12);
}

TEST(FaultPlugin, ReceiverReportsTheFixOfTheFault) {
  test::PluginHarness harness;
  const auto gps = harness.bus.advertise<GpsSample>("iris0/gps");
  harness.add("fault",
              "{faults: [{at_s: 0, fix: {type: 2, satellites: 4, eph_m: 12, epv_m: 20}}]}");
  const test::Heard<GpsSample> heard(harness, "gps");
  const GpsSample& read = heard.newest;
  harness.step();
  gps.publish({.time = {}, .position = test::kHome, .velocity_N = {1, 2, 3}, .eph_m = 0.5});
  EXPECT_EQ(read.fix_type, 2);
  EXPECT_EQ(read.satellites, 4);
  EXPECT_EQ(read.eph_m, 12);
  EXPECT_EQ(read.epv_m, 20);
  EXPECT_EQ(read.velocity_N, Vector3d(1, 2, 3));
}

/// A receiver that stands at home, with ten satellites of 44 dB-Hz on the mean, read at 10 Hz.
class FaultyReceiver {
 public:
  explicit FaultyReceiver(const std::string& fault) : harness_(milliseconds(100)) {
    fixes_ = harness_.bus.advertise<GpsSample>("iris0/gps");
    harness_.add("fault", "{faults: [{at_s: 0, " + fault + "}]}");
    listening_ = harness_.bus.subscribe<GpsSample>(
        "iris0/gps", [this](const GpsSample& sample) { read_ = sample; });
  }
  const GpsSample& next() {
    harness_.step();
    now_ += milliseconds(100);
    fixes_.publish({.time = now_, .position = test::kHome, .eph_m = 0.5, .epv_m = 0.8});
    return read_;
  }
  /// Error of the position that was read last: north, east, down.
  Vector3d error_N() const { return projection_.to_local(read_.position); }

 private:
  test::PluginHarness harness_;
  base::LocalProjection projection_{test::kHome};
  Publisher<GpsSample> fixes_;
  Subscription listening_;
  base::SimTime now_;
  GpsSample read_;
};

constexpr double kProjected_m = 1e-6;  // there and back through degrees

TEST(FaultPlugin, ASpoofedPositionRampsAwayWithAVelocityAndAnAccuracyThatFit) {
  FaultyReceiver receiver("spoofed: {velocity_m_s: [2, -1, 0.5]}");
  for (int i = 1; i <= 100; ++i) {
    const GpsSample fix = receiver.next();
    EXPECT_NEAR((receiver.error_N() - 0.1 * (i - 1) * Vector3d(2, -1, 0.5)).norm(), 0,
                kProjected_m);
    EXPECT_EQ(fix.velocity_N, Vector3d(2, -1, 0.5));
    EXPECT_EQ(fix.eph_m, 0.5);
    EXPECT_EQ(fix.satellites, 10);
  }
}

TEST(FaultPlugin, MultipathIsAGaussMarkovProcessOfItsDeviationAndTime) {
  FaultyReceiver receiver("multipath: {position_m: [3, 3, 6], time_constant_s: 2}");
  constexpr int kSamples = 40'000;
  constexpr int kLag = 20;  // 2 s
  std::vector<double> north;
  test::Statistics down;
  for (int i = 0; i < kSamples; ++i) {
    receiver.next();
    north.push_back(receiver.error_N().x());
    down.add(receiver.error_N().z());
  }
  test::Statistics of_north;
  double product = 0;
  for (int i = 0; i < kSamples; ++i) {
    of_north.add(north[i]);
    if (i >= kLag) product += north[i] * north[i - kLag];
  }
  constexpr double kThreeSigma = 0.1;  // of 1000 independent stretches
  EXPECT_NEAR(of_north.stddev() / 3, 1, kThreeSigma);
  EXPECT_NEAR(down.stddev() / 6, 1, kThreeSigma);
  EXPECT_NEAR(product / (kSamples - kLag) / 9, std::exp(-1), kThreeSigma);
}

/// Satellites stand from 49.4 to 38.6 dB-Hz in steps of 1.2 dB, and are lost below 28.
TEST(Jammed, LosesSatellitesAndAccuracyByTheNoise) {
  struct JamCase {
    const char* name;
    double jammer_to_noise_db;
    int satellites;
    double factor;  // of the accuracy: sqrt((1 + J/N) 10 / satellites); 0: no fix
  };
  const JamCase rows[] = {{"All", 10, 10, std::sqrt(11.0)},
                          {"Six", 15, 6, std::sqrt(32.6228 * 10 / 6)},
                          {"None", 30, 0, 0}};
  for (const auto& jam : rows) {
    SCOPED_TRACE(jam.name);
    FaultyReceiver receiver(
        "jammed: {jammer_to_noise_db: " + std::to_string(jam.jammer_to_noise_db) + "}");
    test::Statistics north;
    for (int i = 0; i < 4000; ++i) {
      const GpsSample& fix = receiver.next();
      ASSERT_EQ(fix.satellites, jam.satellites);
      EXPECT_NEAR(fix.cn0_db_hz,
                  44 - 10 * std::log10(1 + std::pow(10, jam.jammer_to_noise_db / 10)), 1e-9);
      EXPECT_EQ(fix.fix_type, jam.factor > 0 ? 3 : 1);
      EXPECT_NEAR(fix.eph_m, jam.factor > 0 ? 0.5 * jam.factor : 99, 1e-3);
      north.add(receiver.error_N().x());
    }
    if (jam.factor == 0) continue;
    const double added = 0.5 * std::sqrt((jam.factor * jam.factor - 1) / 2);  // of each axis
    EXPECT_NEAR(north.stddev() / added, 1, 0.05);
  }
}

TEST(FaultPlugin, AJammerRisesInDecibels) {
  FaultyReceiver receiver("jammed: {jammer_to_noise_db: 20, rise_s: 10}");
  const double loss_db = 10 * std::log10(101.0);
  for (int i = 1; i <= 150; ++i) {
    EXPECT_NEAR(receiver.next().cn0_db_hz, 44 - loss_db * std::min(1.0, 0.01 * (i - 1)), 1e-9);
  }
}

/// (300 rad/s over the speed in a hover)^2 times the amplitude stands in the spectrum at 300 rad/s.
TEST(FaultPlugin, VibrationStandsInTheSpectrumAtTheSpeedOfTheRotor) {
  test::PluginHarness harness;
  const auto speeds = harness.bus.advertise<RotorSpeeds>("iris0/rotor_speeds");
  const auto imu = harness.bus.advertise<ImuSample>("iris0/imu");
  harness.add("fault",
              "{faults: [{at_s: 0, vibration: {sensor: imu, specific_force_m_s2: [10, 0, 0]}}]}");
  const test::Heard<ImuSample> heard(harness, "imu");
  const ImuSample& read = heard.newest;
  constexpr double kSpeed = 300;
  RotorSpeeds turning;
  turning.omega_rad_s = Vector4d(kSpeed, 0, 0, 0);
  const auto amplitude = [&](double omega) {
    constexpr int kSamples = 4189;  // 200 turns
    double sine = 0, cosine = 0;
    for (int i = 0; i < kSamples; ++i) {
      speeds.publish(turning);
      harness.step();
      imu.publish({});
      sine += read.specific_force_B.x() * std::sin(omega * 1e-3 * i) * 2 / kSamples;
      cosine += read.specific_force_B.x() * std::cos(omega * 1e-3 * i) * 2 / kSamples;
    }
    EXPECT_EQ(read.specific_force_B.y(), 0);
    return std::hypot(sine, cosine);
  };
  const base::Vehicle vehicle = test::load_vehicle("iris_px4");
  const double hover = std::sqrt(vehicle.mass_kg * test::kGravity / 4 /
                                 vehicle.rotors.front().params.thrust_coefficient);
  EXPECT_NEAR(amplitude(kSpeed) / (10 * kSpeed * kSpeed / hover / hover), 1, 0.01);
  EXPECT_LT(amplitude(1.3 * kSpeed), 0.02);
}

TEST(FaultPlugin, ABlindCameraSeesNoFlowAndSaysSo) {
  test::PluginHarness harness;
  const auto flow = harness.bus.advertise<FlowSample>("iris0/optical_flow");
  harness.add("fault", "{faults: [{at_s: 0, blind: optical_flow}]}");
  const test::Heard<FlowSample> heard(harness, "optical_flow");
  const FlowSample& read = heard.newest;
  harness.step();
  flow.publish({.time = {},
                .time_s = 0.05,
                .flow_rad = {0.1, 0.2},
                .turn_rad = {1, 2, 3},
                .quality = 255,
                .distance_m = 4});
  EXPECT_EQ(read.quality, 0);
  EXPECT_EQ(read.flow_rad.norm(), 0);
  EXPECT_EQ(read.turn_rad, Vector3d(1, 2, 3));
  EXPECT_EQ(read.distance_m, 4);
}

TEST(FaultPlugin, ACameraThatLooksForABeaconIsBlindOrOff) {
  test::PluginHarness harness;
  const auto pictures = harness.bus.advertise<LandingTargetSample>("iris0/landing_target");
  harness.add("fault",
              "{faults: [{at_s: 0, bias: {sensor: landing_target, angles_deg: [2, -1, 0]}}, "
              "{at_s: 0.001, blind: landing_target}]}");
  const test::Heard<LandingTargetSample> heard(harness, "landing_target");
  const LandingTargetSample& read = heard.newest;
  const LandingTargetSample picture{
      .time = {}, .seen = true, .angles_rad = {0.1, 0.2}, .distance_m = 4};
  harness.step();
  pictures.publish(picture);
  EXPECT_TRUE(read.seen);
  constexpr double kDegree = M_PI / 180;
  EXPECT_NEAR(read.angles_rad.x(), 0.1 + 2 * kDegree, 1e-12);
  EXPECT_NEAR(read.angles_rad.y(), 0.2 - kDegree, 1e-12);
  harness.step();
  pictures.publish(picture);
  EXPECT_FALSE(read.seen);
}

TEST_F(FaultyVehicle, ADesynchronisedMotorHasNoCurrentForAWhile) {
  start("{faults: [{at_s: 0.1, for_s: 0.1, rotor: {number: 2, desync: true}}]}");
  const test::Heard<PropulsionHealth> heard(harness_, "propulsion_health");
  const PropulsionHealth& health = heard.newest;
  run(milliseconds(150));
  EXPECT_TRUE(health.without_current[1]);
  EXPECT_FALSE(health.without_current[0]);
  run(milliseconds(100));
  EXPECT_FALSE(health.without_current[1]);
}

TEST_F(FaultyVehicle, SticksReversesAndSwapsRotors) {
  start(
      "{faults: [{at_s: 0.1, rotor: {number: 1, stuck: true}}, "
      "{at_s: 0.1, rotor: {number: 2, thrust_share: -0.5}}, "
      "{at_s: 0.1, for_s: 0.1, swap_rotors: [3, 4]}]}");
  const test::Heard<PropulsionHealth> heard(harness_, "propulsion_health");
  const PropulsionHealth& health = heard.newest;
  run(milliseconds(150));
  EXPECT_TRUE(health.stuck[0]);
  EXPECT_FALSE(health.stuck[1]);
  EXPECT_DOUBLE_EQ(health.thrust_share[1], -0.5);
  EXPECT_EQ(health.wired_as[2], 3);
  EXPECT_EQ(health.wired_as[3], 2);
  run(milliseconds(100));
  EXPECT_EQ(health.wired_as[2], 2);
  EXPECT_TRUE(health.stuck[0]);
}

TEST_F(FaultyVehicle, BeginsOnAStateAndEndsOnAnother) {
  start("{faults: [{name: high, when: altitude > 2, until: altitude < 1, drop: barometer}]}");
  run(milliseconds(100));
  harness_.world.body.p_WB.z() = 2.5;
  run(milliseconds(100));
  harness_.world.body.p_WB.z() = 0.5;
  run(milliseconds(100));
  harness_.world.body.p_WB.z() = 2.5;  // once is enough
  run(milliseconds(100));
  EXPECT_EQ(pressures_.size(), 15U);
  const std::string stats = plugin_->stats_json();
  EXPECT_EQ(stats,
            "{\"events\":[{\"time_s\":0.1,\"fault\":\"high\",\"event\":\"begin\"},"
            "{\"time_s\":0.2,\"fault\":\"high\",\"event\":\"end\"}]}");
}

TEST_F(FaultyVehicle, KnowsThePhaseOfTheFlight) {
  const auto phase = harness_.bus.advertise<FlightPhase>("iris0/flight_phase");
  start("{faults: [{when: phase == hold, drop: barometer}]}");
  run(milliseconds(100));
  FlightPhase hold;
  std::string("hold").copy(hold.name.data(), hold.name.size() - 1);
  phase.publish(hold);
  run(milliseconds(100));
  EXPECT_EQ(pressures_.size(), 5U);
}

TEST_F(FaultyVehicle, StopsWeakensAndStarvesRotors) {
  start(
      "{faults: [{at_s: 0.1, rotor: {number: 2, stop: true}}, "
      "{at_s: 0.2, for_s: 0.1, rotor: {number: 3, thrust_share: 0.6}}, "
      "{at_s: 0.2, voltage_share: 0.9}]}");
  const test::Heard<PropulsionHealth> heard(harness_, "propulsion_health");
  const PropulsionHealth& health = heard.newest;
  run(milliseconds(150));
  EXPECT_TRUE(health.speed_share.head<4>().isApprox(Vector4d(1, 0, 1, 1)));
  EXPECT_TRUE(health.thrust_share.head<4>().isApprox(Vector4d::Ones()));
  run(milliseconds(100));
  EXPECT_TRUE(health.thrust_share.head<4>().isApprox(Vector4d(1, 1, 0.6, 1)));
  EXPECT_DOUBLE_EQ(health.voltage_share, 0.9);
  run(milliseconds(100));
  EXPECT_TRUE(health.thrust_share.head<4>().isApprox(Vector4d::Ones()));
}

TEST_F(FaultyVehicle, ChangesMassAndBalance) {
  start(
      "{faults: [{at_s: 0.1, for_s: 0.1, mass_factor: 1.5}, {at_s: 0.3, cg_shift_B_m: [0.02, 0, "
      "0]}]}");
  run(milliseconds(150));
  EXPECT_DOUBLE_EQ(harness_.world.mass_factor, 1.5);
  run(milliseconds(100));
  EXPECT_DOUBLE_EQ(harness_.world.mass_factor, 1.0);
  EXPECT_TRUE(harness_.world.added.torque_B.isZero(0.0));
  run(milliseconds(51));
  // Weight held by surface forces: nose-heavy by m g 0.02 about +By.
  EXPECT_NEAR(harness_.world.added.torque_B.y(), 1.55 * test::kGravity * 0.02, 1e-9);
}

TEST_F(FaultyVehicle, AsksTheWindForAGust) {
  start("{faults: [{at_s: 0.1, gust: {amplitude_m_s: [3, 0, 0], length_m: 2}}]}");
  harness_.add("wind", "{}");
  run(milliseconds(100));
  EXPECT_TRUE(harness_.world.air.wind_W.isZero(0.0));
  run(milliseconds(2000));  // 1 m/s in still air: 2 m take 2 s
  EXPECT_NEAR(harness_.world.air.wind_W.y(), 3, 0.05);
}

TEST_F(FaultyVehicle, WarnsOfAGustWithoutWind) {
  start("{faults: [{at_s: 0.1, gust: {amplitude_m_s: [3, 0, 0], length_m: 2}}]}");
  run(milliseconds(1));
  EXPECT_THAT(plugin_->stats_json(),
              HasSubstr(R"("warnings":["plugin fault: a fault starts a gust)"));
}

TEST_F(FaultyVehicle, TakesFaultsByHandAndForgetsThemAtAReset) {
  const auto order = orders("fault_order");
  start("{by_hand: true}");
  const test::Heard<PropulsionHealth> heard(harness_, "propulsion_health");
  const PropulsionHealth& health = heard.newest;
  run(milliseconds(50));
  EXPECT_TRUE(health.thrust_share.isOnes());
  order("{name: weak, at_s: 0, for_s: 0.05, rotor: {number: 3, thrust_share: 0.6}}");
  run(milliseconds(20));
  EXPECT_DOUBLE_EQ(health.thrust_share[2], 0.6);
  run(milliseconds(50));
  EXPECT_TRUE(health.thrust_share.isOnes());
  EXPECT_THROW(order("{at_s: 0, rotor: {number: 5, stop: true}}"), base::ConfigError);
  EXPECT_THROW(order("{at_s: 0, nothing: 1}"), base::ConfigError);
  EXPECT_THROW(order("{at_s: 0, gust: {amplitude_m_s: [3, 0, 0], length_m: 2}}"), base::ConfigError)
      << "without wind none blows";
  harness_.reset();
  now_ = {};
  run(milliseconds(100));
  EXPECT_TRUE(health.thrust_share.isOnes()) << "the same run as without a hand";
}

TEST_F(FaultyVehicle, EndsWhatWasOrderedByItsName) {
  const auto order = orders("station_fault_order");
  start("{by_hand: true, faults: [{name: weak, at_s: 0, rotor: {number: 1, thrust_share: 0.8}}]}");
  const test::Heard<PropulsionHealth> heard(harness_, "propulsion_health");
  const PropulsionHealth& health = heard.newest;
  order("{name: weak, at_s: 0, rotor: {number: 3, thrust_share: 0.6}}");
  order("{name: weaker, at_s: 0, rotor: {number: 2, thrust_share: 0.5}}");
  run(milliseconds(20));
  EXPECT_DOUBLE_EQ(health.thrust_share[2], 0.6);
  order("{end: weak}");
  run(milliseconds(20));
  EXPECT_DOUBLE_EQ(health.thrust_share[2], 1);
  EXPECT_DOUBLE_EQ(health.thrust_share[0], 0.8) << "the configuration's own goes on";
  EXPECT_DOUBLE_EQ(health.thrust_share[1], 0.5);
  order("{name: late, at_s: 0, rotor: {number: 4, stop: true}}");
  order("{end: late}");  // before it began
  order("{end: nothing}");
  run(milliseconds(20));
  EXPECT_DOUBLE_EQ(health.speed_share[3], 1);
}

TEST_F(FaultyVehicle, DropsSamplesByChanceAndByCount) {
  start(
      "{faults: [{at_s: 0.2, for_s: 0.4, drop: {sensor: barometer, share: 0.5}}, "
      "{at_s: 1, for_s: 0.4, drop: {sensor: barometer, all_but: 4}}]}");
  const auto samples_of = [this](base::Duration time) {
    const std::size_t before = pressures_.size();
    run(time);
    return pressures_.size() - before;
  };
  const std::size_t all = samples_of(milliseconds(180));
  ASSERT_GE(all, 9U);
  run(milliseconds(40));
  const std::size_t by_chance = samples_of(milliseconds(360));
  EXPECT_GT(by_chance, 0U);
  EXPECT_LT(by_chance, 2 * all);
  run(milliseconds(420));
  run(milliseconds(40));
  const std::size_t by_count = samples_of(milliseconds(320));
  EXPECT_GE(by_count, 320 * all / 180 / 4 - 1);
  EXPECT_LE(by_count, 320 * all / 180 / 4 + 1);
}

TEST_F(FaultyVehicle, BreaksTheSameWayAfterReset) {
  start("{faults: [{at_s: 0.05, noise: {sensor: barometer, pressure_pa: 50}}]}");
  run(milliseconds(400));
  const auto first = std::move(pressures_);
  pressures_.clear();
  now_ = {};
  harness_.reset();
  run(milliseconds(400));
  ASSERT_EQ(first.size(), pressures_.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].sample.pressure_pa, pressures_[i].sample.pressure_pa);
  }
  EXPECT_GT(std::abs(first[10].sample.pressure_pa - first[1].sample.pressure_pa), 1);
}

}  // namespace
}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
// The VectorNav without its line: what ArduPilot's drivers ask, and what they get.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "base/earth/frames.hpp"
#include "plugins/common/gps_time.hpp"
#include "plugins/external_ahrs/attitude_solution.hpp"
#include "plugins/external_ahrs/vector_nav.hpp"
#include "tests/plugins/vector_nav_driver.hpp"

namespace cas::sim {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::nmea_line;

constexpr unsigned kBaud = 921'600;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

UnitReadings some_readings() {
  UnitReadings r;
  r.startup_ns = 5'000'000'123;
  r.gps_ns = 1'400'000'000'000'000'000;
  r.accel_D = {0.5, -0.25, -9.75};
  r.gyro_D = {0.125, 0.25, -0.5};
  r.field_D = {0.2, 0.01, 0.4};
  r.temperature_degc = 15;
  r.pressure_pa = 95'000;
  r.solution.q_ND = base::quaternion_rpy(0.1, -0.2, 1.5);
  r.solution.position = {47.5, 8.5, 500};
  r.solution.velocity_N = {1, 2, -3};
  r.fix.type = 3;
  r.fix.satellites = 14;
  r.fix.position = {47.25, 8.75, 501};
  r.fix.velocity_N = {4, 5, 6};
  r.fix.horizontal_sigma_m = 0.9;
  r.fix.vertical_sigma_m = 1.2;
  return r;
}

/// Reads a packet's fields one after the other.
class Fields {
 public:
  Fields(std::span<const std::uint8_t> packet, std::size_t header)
      : rest_(packet.subspan(header)) {}
  template <class T>
  T next() {
    T value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_ = rest_.subspan(sizeof value);
    return value;
  }
  Eigen::Vector3d next_vector() {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = next<float>();
    return v;
  }
  std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::uint8_t> rest_;
};

std::vector<std::uint8_t> build(std::vector<std::string_view> words) {
  BinaryOutput output;
  std::string problem;
  EXPECT_TRUE(output.write(words, problem)) << problem;
  std::vector<std::uint8_t> packet;
  output.build(some_readings(), packet);
  EXPECT_EQ(packet.size(), output.packet_bytes());
  return packet;
}

TEST(Layout, FollowsTheMasksOfTheDriver) {
  struct LayoutCase {
    const char* name;
    std::vector<std::string_view> words;
    std::vector<std::uint8_t> header;
    std::size_t bytes;
  };
  const LayoutCase rows[] = {{"Imu46", {"3", "2", "01", "0721"}, {0xFA, 0x01, 0x21, 0x07}, 82},
                             {"Ins46",
                              {"3", "16", "31", "0001", "0106", "0613"},
                              {0xFA, 0x31, 0x01, 0x00, 0x06, 0x01, 0x13, 0x06},
                              104},
                             {"Gnss46",
                              {"3", "160", "49", "0003", "26B8", "0018"},
                              {0xFA, 0x49, 0x03, 0x00, 0xB8, 0x26, 0x18, 0x00},
                              110},
                             {"Attitude46OfAVn100",
                              {"3", "16", "11", "0001", "0106"},
                              {0xFA, 0x11, 0x01, 0x00, 0x06, 0x01},
                              56},
                             {"Fast45",
                              {"3", "1", "34", "072E", "0106", "0612"},
                              {0xFA, 0x34, 0x2E, 0x07, 0x06, 0x01, 0x12, 0x06},
                              170},
                             {"Slow45",
                              {"3", "80", "4E", "0002", "0010", "20B8", "0018"},
                              {0xFA, 0x4E, 0x02, 0x00, 0x10, 0x00, 0xB8, 0x20, 0x18, 0x00},
                              92}};
  for (const auto& layout : rows) {
    SCOPED_TRACE(layout.name);
    const std::vector<std::uint8_t> packet = build(layout.words);
    EXPECT_EQ(packet.size(), layout.bytes);
    EXPECT_TRUE(std::equal(layout.header.begin(), layout.header.end(), packet.begin()));
    EXPECT_EQ(vector_nav_crc(std::span(packet).subspan(1)), 0);
  }
}

TEST(VectorNavCrc, IsThatOfTheStandardsCheckWord) {
  const std::string check = "123456789";
  EXPECT_EQ(vector_nav_crc(bytes_of(check)), 0x31C3);  // CRC-16/XMODEM
}

TEST(BinaryOutput, ImuPacketHasItsFieldsInTheOrderOfTheirBits) {
  const auto packet = build({"3", "2", "01", "0721"});
  const UnitReadings r = some_readings();
  Fields fields(packet, 4);
  EXPECT_EQ(fields.next<std::uint64_t>(), r.startup_ns);
  EXPECT_TRUE(fields.next_vector().isApprox(r.gyro_D));
  EXPECT_TRUE(fields.next_vector().isApprox(r.accel_D));
  EXPECT_TRUE(fields.next_vector().isApprox(r.accel_D));
  EXPECT_TRUE(fields.next_vector().isApprox(r.gyro_D));
  EXPECT_TRUE(fields.next_vector().isApprox(r.field_D, 1e-6));
  EXPECT_FLOAT_EQ(fields.next<float>(), 15);
  EXPECT_FLOAT_EQ(fields.next<float>(), 95);  // kPa
  EXPECT_EQ(fields.left(), 2U);
}

TEST(BinaryOutput, InsPacketIsInDegreesAndVectorFirstQuaternion) {
  const auto packet = build({"3", "16", "31", "0001", "0106", "0613"});
  const UnitReadings r = some_readings();
  Fields fields(packet, 8);
  fields.next<std::uint64_t>();
  EXPECT_NEAR(fields.next<float>(), 1.5 * 180 / M_PI, 1e-4);
  EXPECT_NEAR(fields.next<float>(), -0.2 * 180 / M_PI, 1e-4);
  EXPECT_NEAR(fields.next<float>(), 0.1 * 180 / M_PI, 1e-4);
  EXPECT_FLOAT_EQ(fields.next<float>(), static_cast<float>(r.solution.q_ND.x()));
  fields.next<float>(), fields.next<float>();
  EXPECT_FLOAT_EQ(fields.next<float>(), static_cast<float>(r.solution.q_ND.w()));
  fields.next_vector();
  EXPECT_EQ(fields.next<std::uint16_t>(), 6) << "tracks, with a fix";
  EXPECT_EQ(fields.next<double>(), 47.5);
  EXPECT_EQ(fields.next<double>(), 8.5);
  EXPECT_EQ(fields.next<double>(), 500);
  EXPECT_TRUE(fields.next_vector().isApprox(r.solution.velocity_N));
}

TEST(BinaryOutput, GnssPacketIsOfTheReceiver) {
  const auto packet = build({"3", "160", "49", "0003", "26B8", "0018"});
  const UnitReadings r = some_readings();
  Fields fields(packet, 8);
  fields.next<std::uint64_t>();
  EXPECT_EQ(fields.next<std::uint64_t>(), r.gps_ns);
  EXPECT_EQ(fields.next<std::uint8_t>(), 14);
  EXPECT_EQ(fields.next<std::uint8_t>(), 3);
  EXPECT_EQ(fields.next<double>(), 47.25);
  EXPECT_EQ(fields.next<double>(), 8.75);
  EXPECT_EQ(fields.next<double>(), 501);
  EXPECT_TRUE(fields.next_vector().isApprox(r.fix.velocity_N));
  EXPECT_TRUE(fields.next_vector().isApprox(Eigen::Vector3d(0.9, 0.9, 1.2), 1e-6));
  fields.next<float>();
  for (int i = 0; i < 3; ++i) fields.next<float>();
  EXPECT_FLOAT_EQ(fields.next<float>(), 1.2F) << "vertical dilution is the fourth";
  EXPECT_FLOAT_EQ(fields.next<float>(), 0.9F) << "horizontal the fifth";
  fields.next<float>(), fields.next<float>();
  EXPECT_EQ(fields.next<std::uint8_t>(), 0) << "a VN-200 has one receiver";
  EXPECT_EQ(fields.next<std::uint8_t>(), 0);
  EXPECT_EQ(fields.left(), 2U);
}

TEST(BinaryOutput, RefusesWhatIsNotSimulatedAndKeepsWhatWas) {
  BinaryOutput output;
  std::string problem;
  const std::vector<std::string_view> good{"3", "2", "01", "0721"};
  ASSERT_TRUE(output.write(good, problem));
  const std::vector<std::vector<std::string_view>> bad{
      {"3", "2", "01", "0800"}, {"3", "2", "80", "0001"},
      {"3", "2", "01"},         {"3", "0", "01", "0721"},
      {"3", "x", "01", "0721"}, {"3", "2", "01", "0721", "0001"},
      {"9", "2", "01", "0721"}, {"3"}};
  for (const auto& words : bad) EXPECT_FALSE(output.write(words, problem)) << words.back();
  EXPECT_EQ(output.packet_bytes(), 82U);
  ASSERT_FALSE(output.write(bad[0], problem));
  EXPECT_EQ(problem, "field 11 of group 0 is not simulated");
}

std::string answer_to(UnitRegisters& registers, const std::string& body) {
  std::string replies;
  registers.feed(bytes_of(nmea_line(body)), replies);
  return replies;
}

TEST(UnitRegisters, AnswersTheHandshakeOfArducopter462) {
  UnitRegisters registers("VN-200");
  for (const char* body : {"VNASY,0", "VNWRG,06,0,1", "VNWRG,06,0,2"}) {
    EXPECT_EQ(answer_to(registers, body), nmea_line(body));
  }
  EXPECT_EQ(answer_to(registers, "VNRRG,01"), nmea_line("VNRRG,01,VN-200"));
  for (const char* body : {"VNWRG,75,3,2,01,0721", "VNWRG,76,3,16,31,0001,0106,0613",
                           "VNWRG,77,3,160,49,0003,26B8,0018"}) {
    EXPECT_EQ(answer_to(registers, body), nmea_line(body));
    EXPECT_FALSE(registers.running()) << "paused until VNASY,1";
  }
  EXPECT_EQ(answer_to(registers, "VNASY,1"), nmea_line("VNASY,1"));
  EXPECT_TRUE(registers.running());
  EXPECT_EQ(registers.counts().lines, 8U);
  EXPECT_EQ(registers.counts().refused, 0U);
  EXPECT_EQ(registers.asked().size(), 8U);
}

TEST(UnitRegisters, AnswersTheHandshakeOfArducopter457) {
  UnitRegisters registers("VN-300");
  for (const char* body : {"VNASY,0", "VNWRG,75,3,1,34,072E,0106,0612",
                           "VNWRG,76,3,80,4E,0002,0010,20B8,0018", "VNASY,1"}) {
    EXPECT_EQ(answer_to(registers, body), nmea_line(body));
  }
  EXPECT_TRUE(registers.running());
  EXPECT_EQ(registers.outputs()[0].packet_bytes(), 170U);
  EXPECT_EQ(registers.outputs()[1].packet_bytes(), 92U);
}

TEST(UnitRegisters, RefusesByErrorAnswersAndSaysWhy) {
  UnitRegisters registers("VN-200");
  EXPECT_EQ(answer_to(registers, "VNRST"), nmea_line("VNERR,04"));
  EXPECT_EQ(answer_to(registers, "VNRRG,57"), nmea_line("VNERR,08"));
  EXPECT_EQ(answer_to(registers, "VNWRG,75,3,2,01,0800"), nmea_line("VNERR,07"));
  EXPECT_EQ(registers.refusal(), "register 75: field 11 of group 0 is not simulated");
  EXPECT_EQ(registers.counts().refused, 3U);
}

TEST(UnitRegisters, CountsAndSurvivesGarbage) {
  UnitRegisters registers("VN-200");
  std::string replies;
  std::vector<std::uint8_t> noise{0xFA, 0x01, 0x00, 'V', 'N'};
  registers.feed(noise, replies);
  EXPECT_EQ(registers.counts().garbage_bytes, 5U);
  registers.feed(bytes_of("$VNRRG,01*00\r\n"), replies);
  EXPECT_EQ(registers.counts().bad_checksums, 1U);
  EXPECT_EQ(replies, nmea_line("VNERR,03"));
  replies.clear();
  registers.feed(bytes_of("$VNRR$VNRRG,01*72\r\n"), replies);  // a line that broke off
  EXPECT_EQ(registers.counts().garbage_bytes, 10U);
  EXPECT_EQ(replies, nmea_line("VNRRG,01,VN-200"));
  replies.clear();
  registers.feed(bytes_of("$" + std::string(5000, 'x')), replies);  // one that never ends
  registers.feed(bytes_of(nmea_line("VNRRG,01")), replies);
  EXPECT_EQ(replies, nmea_line("VNRRG,01,VN-200"));
  EXPECT_EQ(registers.counts().garbage_bytes, 5011U);
}

/// A unit that was asked for packets, stepped at 800 Hz.
class RunningUnit {
 public:
  RunningUnit(UnitModel model, unsigned baud, const std::vector<std::string>& asks)
      : unit(model, baud) {
    for (const std::string& body : asks) unit.receive(bytes_of(nmea_line(body)));
    unit.take_answers({});
    unit.advance({});
  }

  /// @param has_sample  whether each step brings new samples
  void run(base::Duration time, bool has_sample = true) {
    for (const base::SimTime end = now + time; now < end;) {
      now += microseconds(1250);
      unit.advance(now);
      if (has_sample) fresh = {true, true};
      while (!unit.next(now, readings, fresh).empty()) {
      }
    }
  }

  VectorNav unit;
  UnitReadings readings = some_readings();
  FreshSamples fresh;
  base::SimTime now{};
};

const std::vector<std::string> kAsks46{"VNWRG,75,3,2,01,0721", "VNWRG,76,3,16,31,0001,0106,0613",
                                       "VNWRG,77,3,160,49,0003,26B8,0018", "VNASY,1"};

TEST(VectorNav, SendsAtTheRatesThatItWasAskedFor) {
  RunningUnit bench(UnitModel::kVn200, kBaud, kAsks46);
  bench.run(std::chrono::seconds(2));
  const VectorNav::Counts& counts = bench.unit.counts();
  EXPECT_EQ(counts.sent[0], 800U);
  EXPECT_EQ(counts.sent[1], 100U);
  EXPECT_GE(counts.sent[2], 9U) << "the tenth waits for a gap";
  EXPECT_EQ(counts.dropped, 0U);
  EXPECT_EQ(counts.late, 0U) << "others go between two of the inertial packets";
  EXPECT_EQ(bench.unit.rate_hz(0), 400);
}

TEST(VectorNav, CarriesEightHundredHertzAt921600Baud) {
  RunningUnit bench(UnitModel::kVn200, kBaud,
                    {"VNWRG,75,3,1,01,0721", kAsks46[1], kAsks46[2], "VNASY,1"});
  bench.run(std::chrono::seconds(2));
  EXPECT_EQ(bench.unit.counts().sent[0], 1600U);
  EXPECT_GE(bench.unit.counts().sent[1], 99U) << "the last one waits for a gap";
  EXPECT_GE(bench.unit.counts().sent[2], 9U);
  EXPECT_EQ(bench.unit.counts().dropped, 0U);
  EXPECT_LE(bench.unit.counts().longest_wait, milliseconds(3));
}

TEST(VectorNav, DropsWhatTheLineCannotCarryAndNothingIsOld) {
  constexpr unsigned kSlow = 230'400;  // 23 kB/s for 38.6 kB/s
  RunningUnit bench(UnitModel::kVn200, kSlow, kAsks46);
  bench.run(std::chrono::seconds(2));
  const VectorNav::Counts& counts = bench.unit.counts();
  EXPECT_GT(counts.dropped, 200U);
  const std::uint64_t all = counts.sent[0] + counts.sent[1] + counts.sent[2] + counts.dropped;
  EXPECT_LE(all, 910U);
  EXPECT_GE(all, 907U) << "each packet is accounted for, but for those that still wait";
  EXPECT_LE(counts.longest_wait, VectorNav::kMostWait);
  EXPECT_LE(counts.bytes, 2U * kSlow / 10 + 400);
}

TEST(VectorNav, SendsNoSampleTwice) {
  RunningUnit bench(UnitModel::kVn200, kBaud, kAsks46);
  bench.run(milliseconds(500), false);
  EXPECT_EQ(bench.unit.counts().sent[0], 0U);
  EXPECT_EQ(bench.unit.counts().sent[1], 25U) << "its attitude needs no new sample";
  EXPECT_EQ(bench.unit.counts().sent[2], 0U);
  EXPECT_GE(bench.unit.counts().without_sample, 199U);
  EXPECT_EQ(bench.unit.counts().dropped, 0U);
}

TEST(VectorNav, IsSilentWhilePaused) {
  RunningUnit bench(UnitModel::kVn200, kBaud, kAsks46);
  bench.run(milliseconds(100));
  bench.unit.receive(bytes_of(nmea_line("VNASY,0")));
  bench.unit.take_answers(bench.now);
  const auto before = bench.unit.counts().sent;
  bench.run(milliseconds(100));
  EXPECT_EQ(bench.unit.counts().sent, before);
  EXPECT_EQ(bench.unit.rate_hz(0), 0);
}

TEST(GpsTime, OfTheYear2026) {
  constexpr std::uint64_t kDay_ns = 24ULL * 3600 * 1'000'000'000;
  // 1980-01-06 to 2026-01-01: 16 797 days, and 18 leap seconds.
  EXPECT_EQ(gps_time_ns(2026.0), 16'797 * kDay_ns + 18'000'000'000ULL);
  EXPECT_EQ(gps_time_ns(2026.5) - gps_time_ns(2026.0), kDay_ns * 365 / 2);
}

TEST(AttitudeSolution, FindsAndKeepsTheAttitudeOfItsSensors) {
  constexpr double kDeclination = 0.06;
  constexpr double kDt = 0.0025;
  const Eigen::Vector3d field_N(0.2 * std::cos(kDeclination), 0.2 * std::sin(kDeclination), 0.4);
  const Eigen::Vector3d rate_D(0, 0, 0.5);
  const Eigen::Vector3d bias_D(0.002, -0.002, 0.002);
  AttitudeSolution solution(kDeclination);
  Eigen::Quaterniond truth = base::quaternion_rpy(0.2, -0.1, 2.5);
  for (int i = 0; i < 8000; ++i) {
    const Eigen::Vector3d accel_D = truth.conjugate() * Eigen::Vector3d(0, 0, -9.80665);
    solution.on_field(truth.conjugate() * field_N);
    solution.on_inertial(accel_D, rate_D + bias_D, kDt);
    truth = truth * Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * kDt, Eigen::Vector3d::UnitZ()));
  }
  EXPECT_LT(solution.q_ND().angularDistance(truth), 0.02);
}

}  // namespace
}  // namespace cas::sim

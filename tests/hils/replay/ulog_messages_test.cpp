// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/ulog_messages.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/hils/ulog/ulog_bytes.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using cas::test::UlogBytes;
using OrderedJson = nlohmann::ordered_json;

constexpr std::uint64_t kStart = 5'000'000;
constexpr std::uint64_t kSecond = 1'000'000;

/// A vehicle on its table: the test adds the data of each topic.
UlogBytes log() {
  return UlogBytes(kStart)
      .pair('I', "char[11] ver_hw", "PX4_FMU_V5X")
      .pair('P', "float GAIN", UlogBytes::number(0.5F))
      .format(
          "vehicle_status:uint64_t timestamp;uint64_t armed_time;uint8_t arming_state;"
          "uint8_t nav_state;uint8_t hil_state;uint8_t system_id;")
      .format("vehicle_land_detected:uint64_t timestamp;bool landed;")
      .format("vehicle_attitude:uint64_t timestamp;float[4] q;")
      .format("place:uint64_t timestamp;uint64_t timestamp_sample;double lat;char[4] note;")
      .subscribe(0, "vehicle_status")
      .subscribe(1, "vehicle_land_detected")
      .subscribe(2, "vehicle_attitude")
      .subscribe(3, "place")
      .subscribe(4, "place", 1);
}

std::string status(std::uint8_t arming_state, std::uint8_t nav_state) {
  return UlogBytes::number(std::uint64_t{0}) + UlogBytes::number(arming_state) +
         UlogBytes::number(nav_state) + UlogBytes::number(std::uint8_t{0}) +
         UlogBytes::number(std::uint8_t{3});
}

std::string place(double lat) {
  return UlogBytes::number(std::uint64_t{0}) + UlogBytes::number(lat) + "note";
}

/// A message of a record by its name.
OrderedJson message(const OrderedJson& vehicle, const std::string& name) {
  for (const OrderedJson& each : vehicle["log"]["messages"]) {
    if (each["name"] == name) return each;
  }
  return {};
}

TEST(ReplayUlog, SaysWhoItIsAndWhatItDid) {
  UlogBytes bytes = log();
  bytes
      .data(0, kStart - kSecond, status(1, 4))  // published before the log began
      .data(0, kStart + kSecond, status(1, 4))
      .data(1, kStart + kSecond, "\x01")
      .data(0, kStart + 2 * kSecond, status(2, 17))
      .data(1, kStart + 3 * kSecond, std::string(1, '\0'))
      .data(0, kStart + 4 * kSecond, status(2, 99))
      .sentence('4', kStart + 5 * kSecond, "low battery\t");
  const OrderedJson vehicle = ulog_messages(bytes.bytes());
  EXPECT_EQ(vehicle["system"], 3);
  EXPECT_EQ(vehicle["controller"], "PX4_FMU_V5X");
  EXPECT_EQ(vehicle["log"]["autopilot"], "PX4");
  EXPECT_EQ(vehicle["log"]["duration_s"], 5.0);
  EXPECT_EQ(vehicle["log"]["texts"].dump(), R"([[5.0,4,"low battery"]])");
  EXPECT_EQ(vehicle["log"]["states"].dump(),
            R"([[0.0,0,"HOLD",0],[1.0,0,"HOLD",1],[2.0,128,"TAKEOFF",1],[3.0,128,"TAKEOFF",2],)"
            R"([4.0,128,"nav state 99",2]])");
}

TEST(ReplayUlog, AModeThatIsNoneIsUnknown) {
  for (const float mode : {std::nanf(""), 1e30F, -1e30F, 256.F}) {
    UlogBytes bytes(kStart);
    bytes.format("vehicle_status:uint64_t timestamp;float nav_state;")
        .subscribe(0, "vehicle_status")
        .data(0, kStart, UlogBytes::number(mode));
    EXPECT_EQ(ulog_messages(bytes.bytes())["log"]["states"].dump(), R"([[0.0,0,"nav state -1",0]])")
        << mode;
  }
}

TEST(ReplayUlog, FieldsThatChangePlacesKeepTheirValues) {
  UlogBytes bytes(kStart);
  bytes.format("pair:uint64_t timestamp;uint8_t a;uint8_t b;")
      .subscribe(0, "pair")
      .format("pair:uint64_t timestamp;uint8_t b;uint8_t a;uint8_t c;")
      .subscribe(1, "pair");
  bytes.data(0, kStart, "\x01\x02").data(1, kStart + kSecond, "\x05\x03\x09");
  const OrderedJson fields = message(ulog_messages(bytes.bytes()), "pair")["fields"];
  ASSERT_EQ(fields.size(), 2U) << "c is not in each message";
  EXPECT_EQ(fields[0]["values"]["d"].dump(), "[1,2]") << "a: 1, 3";
  EXPECT_EQ(fields[1]["values"]["d"].dump(), "[2,3]") << "b: 2, 5";
}

TEST(ReplayUlog, HasEachTopicAtNoMoreThan20HzAndTheAttitudeAsAngles) {
  UlogBytes bytes = log();
  for (std::uint64_t ms = 0; ms < 1000; ms += 10) {
    // Heading east.
    bytes.data(2, kStart + ms * 1000,
               UlogBytes::number(0.70710678F) + UlogBytes::number(0.F) + UlogBytes::number(0.F) +
                   UlogBytes::number(0.70710678F));
  }
  const OrderedJson attitude = message(ulog_messages(bytes.bytes()), "vehicle_attitude");
  EXPECT_EQ(attitude["rates"].dump(), "[[0,100]]");
  EXPECT_EQ(attitude["t"]["d"].size(), 20U);
  std::string names;
  for (const OrderedJson& field : attitude["fields"])
    names += field["name"].get<std::string>() + " ";
  EXPECT_EQ(names, "q[0] q[1] q[2] q[3] roll pitch yaw ");
  const OrderedJson yaw = attitude["fields"][6]["values"];
  EXPECT_NEAR(yaw["k"].get<double>() * yaw["d"][0].get<double>(), 1.5708, 1e-3);
}

TEST(ReplayUlog, ResolvesDegreesOfLatitudeAndKeepsInstancesApart) {
  UlogBytes bytes = log();
  bytes.data(3, kStart, place(47.397742)).data(3, kStart + kSecond, place(47.397752));  // 1.1 m
  bytes.data(4, kStart, place(1.5));
  const OrderedJson vehicle = ulog_messages(bytes.bytes());
  const OrderedJson fields = message(vehicle, "place")["fields"];
  ASSERT_EQ(fields.size(), 1U) << "no further time, no text";
  const OrderedJson lat = fields[0]["values"];
  EXPECT_NEAR(lat["k"].get<double>() * lat["d"][1].get<double>(), 1e-5, 1e-7);
  EXPECT_EQ(message(vehicle, "place[1]")["t"]["d"].size(), 1U);
}

TEST(ReplayUlog, MarksDropoutsDamageAndChangedParameters) {
  UlogBytes bytes = log();
  bytes.data(1, kStart + kSecond, "\x01")
      .dropout(30)
      .dropout(10)
      .pair('P', "float GAIN", UlogBytes::number(0.5F))
      .pair('P', "float GAIN", UlogBytes::number(0.75F))
      .data(1, kStart + 2 * kSecond, "\x01")
      .raw(std::string(20, '\0'))
      .sync();
  EXPECT_EQ(ulog_messages(bytes.bytes())["events"].dump(),
            R"([{"t_s":1.0,"kind":"parameter","text":"GAIN","before":0.5,"after":0.75},)"
            R"({"t_s":1,"kind":"loss","text":"the log lacks 40 ms"},)"
            R"({"t_s":2,"kind":"loss","text":"20 bytes of the log are damaged"}])");
  UlogLoss loss;
  ulog_messages(bytes.bytes(), kMostUlogNumbers, &loss);
  EXPECT_EQ(loss.sentence(), "40 ms are missing, 20 bytes are damaged");
}

TEST(ReplayUlog, MarksTheEndOfACutLog) {
  UlogBytes bytes = log();
  bytes.data(1, kStart + kSecond, "\x01");
  UlogLoss loss;
  EXPECT_TRUE(ulog_messages(bytes.bytes(), kMostUlogNumbers, &loss)["events"].empty());
  EXPECT_EQ(loss.sentence(), "");
  const std::size_t whole = bytes.bytes().size();
  bytes.data(1, kStart + 2 * kSecond, "\x01");
  for (const std::size_t more : {1U, 5U}) {
    const std::string cut = bytes.bytes().substr(0, whole + more);
    EXPECT_EQ(ulog_messages(cut, kMostUlogNumbers, &loss)["events"].dump(),
              R"([{"t_s":1,"kind":"loss","text":"the log ends within a message, of which it has )" +
                  std::to_string(more) + R"( bytes"}])");
    EXPECT_EQ(loss.sentence(), "it ends within a message");
  }
}

TEST(ReplayUlog, OneWrongStampAddsNoTimeButAGapDoes) {
  UlogBytes bytes = log();
  const std::uint64_t of_earlier_flight = kStart + 1174 * kSecond;
  bytes.data(1, kStart + kSecond, "\x01")
      .data(1, UINT64_MAX, "\x01")
      .data(3, of_earlier_flight, place(0))
      .data(3, of_earlier_flight, place(0))
      .data(1, kStart + 2 * kSecond, "\x01");
  EXPECT_EQ(ulog_messages(bytes.bytes())["log"]["duration_s"], 2.0);
  UlogBytes two = bytes;
  two.data(1, kStart + 60 * kSecond, "\x01").data(0, kStart + 61 * kSecond, status(1, 4));
  EXPECT_EQ(ulog_messages(two.bytes())["log"]["duration_s"], 61.0);
  bytes.data(1, kStart + 60 * kSecond, "\x01").data(1, kStart + 80 * kSecond, "\x01");
  EXPECT_EQ(ulog_messages(bytes.bytes())["log"]["duration_s"], 80.0);
}

TEST(ReplayUlog, ATopicWithAClockOfItsOwnIsOutvoted) {
  UlogBytes bytes = log();
  for (std::uint64_t i = 0; i < 300; ++i) {
    const std::uint64_t now = kStart + i * kSecond / 10;
    bytes.data(0, now, status(1, 4)).data(1, now, "\x01");
    if (i >= 100)
      bytes.data(3, 3600 * kSecond + now, place(0)).data(3, 3600 * kSecond + now + 1, place(0));
  }
  UlogLoss loss;
  EXPECT_EQ(ulog_messages(bytes.bytes(), kMostUlogNumbers, &loss)["log"]["duration_s"], 29.9);
  EXPECT_EQ(loss.wrong_stamps, 400U);
}

TEST(ReplayUlog, SentencesHaveNoColours) {
  UlogBytes bytes = log();
  bytes.data(1, kStart, "\x01").sentence('6', kStart, "[commander] \x1b[32mReady\x1b[0m\n");
  bytes.sentence('6', kStart, "cut \x1b[3");
  EXPECT_EQ(ulog_messages(bytes.bytes())["log"]["texts"].dump(),
            R"([[0.0,6,"[commander] Ready"],[0.0,6,"cut"]])");
}

TEST(ReplayUlog, ThinsWhatWouldBeTooMuchButNotWhatIsDrawn) {
  UlogBytes bytes(kStart);
  bytes.format("many:uint64_t timestamp;float[16] x;")
      .format("vehicle_attitude:uint64_t timestamp;float[4] q;")
      .subscribe(0, "many")
      .subscribe(1, "vehicle_attitude");
  constexpr std::size_t kMessages = 400;
  for (std::size_t i = 0; i < kMessages; ++i) {
    bytes.data(0, kStart + i * 50'000, std::string(64, '\0'));
    bytes.data(1, kStart + i * 50'000, std::string(16, '\0'));
  }
  const OrderedJson vehicle = ulog_messages(bytes.bytes(), 16 * kMessages / 2);
  const std::size_t kept = message(vehicle, "many")["t"]["d"].size();
  EXPECT_GT(kept, kMessages / 8);
  EXPECT_LT(kept, kMessages / 2);
  EXPECT_EQ(message(vehicle, "vehicle_attitude")["t"]["d"].size(), kMessages);
}

TEST(ReplayUlog, WithoutAMessageIsRefused) {
  EXPECT_EQ(test::refusal([] { ulog_messages(log().bytes()); }), "no message is in this log");
}

}  // namespace
}  // namespace cas::hils

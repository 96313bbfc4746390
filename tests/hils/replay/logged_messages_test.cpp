// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/logged_messages.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "hils/replay/logged_series.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/tlog.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

/// A log that is being written.
class Log {
 public:
  template <class Message>
  void add(std::uint64_t stamp_us, const Message& message, std::uint8_t component = 1) {
    mav::Encoder encode({1, component});
    mav::services::append_tlog_record(stamp_us, encode(message), bytes_);
  }
  void add_packet(std::uint64_t stamp_us, std::span<const std::uint8_t> packet) {
    mav::services::append_tlog_record(stamp_us, packet, bytes_);
  }
  nlohmann::ordered_json messages(LoggedLoss* lost = nullptr) const {
    const cas::test::TemporaryFolder folder;
    const std::string text(bytes_.begin(), bytes_.end());
    return logged_messages(folder.write("flight.tlog", text), 1, {}, lost);
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Duration of a log that has a heartbeat at each of these stamps.
double duration_s(const std::vector<std::uint64_t>& stamps_us) {
  Log log;
  for (const std::uint64_t stamp : stamps_us) log.add(stamp, mavlink::common::Heartbeat{});
  return log.messages().at("duration_s");
}

TEST(ReplayLog, OneWrongStampAddsNoTime) {
  constexpr std::uint64_t kSecond = 1'000'000;
  constexpr std::uint64_t kBegin = 1'790'000'000 * kSecond;
  EXPECT_DOUBLE_EQ(duration_s({kBegin, kBegin + kSecond, kBegin + 2 * kSecond}), 2);
  EXPECT_DOUBLE_EQ(duration_s({kBegin, kBegin - kSecond, kBegin + kSecond}), 1);  // set back
  for (const std::uint64_t wrong : {std::uint64_t{0}, kBegin * 2, UINT64_MAX, UINT64_MAX / 2 + 1}) {
    const double whole =
        duration_s({kBegin, kBegin + kSecond, wrong, kBegin + 2 * kSecond, kBegin + 3 * kSecond});
    EXPECT_GE(whole, 1) << wrong;
    EXPECT_LE(whole, 3) << wrong;
    EXPECT_LE(duration_s({wrong, kBegin, kBegin + kSecond}), 1) << wrong;
  }
}

TEST(ReplayLog, AClockThatWasSetCostsNoFlight) {
  constexpr std::uint64_t kBegin = 1'790'000'000'000'000;
  constexpr std::uint64_t kHour = 3'600'000'000;
  for (const std::uint64_t from : {kBegin - kHour, kBegin, kBegin + kHour, std::uint64_t{86'400}}) {
    std::vector<std::uint64_t> stamps;
    for (std::uint64_t i = 0; i < 300; ++i)
      stamps.push_back((i < 100 ? kBegin : from) + 100'000 * i);
    EXPECT_NEAR(duration_s(stamps), 29.9, 0.11) << from;
  }
}

TEST(ReplayLog, TheModeIsTheAutopilotsAlone) {
  using mavlink::common::Heartbeat;
  using mavlink::common::MavAutopilot;
  Log log;
  std::uint64_t stamp = 1'790'000'000'000'000;
  const auto add = [&](std::uint8_t component, MavAutopilot autopilot, std::uint32_t mode) {
    Heartbeat heartbeat{.type = mavlink::common::MavType::kFixedWing,
                        .autopilot = autopilot,
                        .base_mode = mavlink::common::MavModeFlag::kCustomModeEnabled,
                        .custom_mode = mode};
    log.add(stamp += 500'000, heartbeat, component);
  };
  for (int i = 0; i < 3; ++i) {
    add(154, MavAutopilot::kInvalid, 0);  // a gimbal
    add(1, MavAutopilot::kArdupilotmega, i < 2 ? 12 : 15);
  }
  const auto states = log.messages().at("states");
  ASSERT_EQ(states.size(), 2U) << states;
  EXPECT_EQ(states[0][2], "LOITER");
  EXPECT_EQ(states[1][2], "GUIDED");
}

TEST(ReplayLog, AMessageOfAnotherDialectThatHoldsAStartByteIsNoDamage) {
  std::vector<std::uint8_t> packet{0xFD, 17, 0, 0, 0, 1, 1, 0x31, 0xD4, 0};  // id 54321
  const std::vector<std::uint8_t> heartbeat_without_checksum{0xFE, 9, 0, 1, 1, 0, 1, 2, 3,
                                                             4,    5, 6, 7, 8, 9, 1, 2};
  packet.insert(packet.end(), heartbeat_without_checksum.begin(), heartbeat_without_checksum.end());
  mav::Crc16 sum;
  sum.update(std::span<const std::uint8_t>(packet).subspan(1));
  const std::uint16_t checksum = sum.update(33).value();
  packet.push_back(static_cast<std::uint8_t>(checksum));
  packet.push_back(static_cast<std::uint8_t>(checksum >> 8U));
  Log log;
  log.add(1'790'000'000'000'000, mavlink::common::Heartbeat{});
  log.add_packet(1'790'000'000'100'000, packet);
  log.add(1'790'000'001'000'000, mavlink::common::Heartbeat{});
  LoggedLoss lost;
  EXPECT_DOUBLE_EQ(log.messages(&lost).at("duration_s"), 1);
  EXPECT_EQ(lost.sentence(), "");
}

TEST(ReplayLog, ALongTextIsOne) {
  Log log;
  mavlink::common::Statustext chunk{.id = 7};
  const std::string full(chunk.text.size(), 'a');
  mav::set_text(chunk.text, full);
  log.add(1'790'000'000'000'000, chunk);
  chunk.chunk_seq = 1;
  mav::set_text(chunk.text, "end");
  log.add(1'790'000'001'000'000, chunk);
  const auto texts = log.messages().at("texts");
  ASSERT_EQ(texts.size(), 1U) << texts;
  EXPECT_EQ(texts[0][2], full + "end");
}

TEST(ReplayLog, ThinningKeepsEverySecondSample) {
  LoggedSeries series(0.1);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(series.take(i));
    series.add("a", "", i);
  }
  EXPECT_EQ(series.numbers(), 10U);
  series.thin();
  EXPECT_EQ(series.numbers(), 6U);
  EXPECT_TRUE(series.take(4.11));
  series.add("a", "", 5);
  EXPECT_FALSE(series.take(4.25));  // the period has doubled
  const auto json = series.json("M");
  EXPECT_EQ(json.at("t").at("d").size(), 4U);
  EXPECT_EQ(json.at("fields").at(0).at("values").at("d").size(), 4U);
}

TEST(ReplayLog, TextsAreBounded) {
  Log log;
  mavlink::common::Statustext text;
  text.text[0] = 'x';
  for (std::uint64_t i = 0; i < 10'100; ++i) log.add(1'790'000'000'000'000 + i, text);
  const auto messages = log.messages();
  ASSERT_EQ(messages.at("texts").size(), 10'001U);
  EXPECT_EQ(messages.at("texts").back().at(2), "(the replay shows no further texts)");
}

}  // namespace
}  // namespace cas::hils

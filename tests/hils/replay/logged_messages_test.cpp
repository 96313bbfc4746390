// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/logged_messages.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

/// Duration of a log that has a heartbeat at each of these stamps.
double duration_s(const std::vector<std::uint64_t>& stamps_us) {
  const cas::test::TemporaryFolder folder;
  mav::Encoder encode({1, 1});
  std::string bytes;
  for (const std::uint64_t stamp : stamps_us) {
    for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(stamp >> shift & 0xFFU);
    const auto packet = encode(mavlink::common::Heartbeat{});
    bytes.append(packet.begin(), packet.end());
  }
  return logged_messages(folder.write("flight.tlog", bytes), 1, {}).at("duration_s");
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

TEST(ReplayLog, TheModeIsTheAutopilotsAlone) {
  using mavlink::common::Heartbeat;
  using mavlink::common::MavAutopilot;
  const cas::test::TemporaryFolder folder;
  std::string bytes;
  std::uint64_t stamp = 1'790'000'000'000'000;
  const auto add = [&](std::uint8_t component, MavAutopilot autopilot, std::uint32_t mode) {
    Heartbeat heartbeat;
    heartbeat.autopilot = autopilot;
    heartbeat.custom_mode = mode;
    for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(stamp >> shift & 0xFFU);
    stamp += 500'000;
    mav::Encoder encode({1, component});
    const auto packet = encode(heartbeat);
    bytes.append(packet.begin(), packet.end());
  };
  for (int i = 0; i < 3; ++i) {
    add(154, MavAutopilot::kInvalid, 0);  // a gimbal
    add(1, MavAutopilot::kPx4, i < 2 ? 7 : 8);
  }
  const auto states = logged_messages(folder.write("flight.tlog", bytes), 1, {}).at("states");
  ASSERT_EQ(states.size(), 2U) << states;
  EXPECT_EQ(states[0][2], 7);
  EXPECT_EQ(states[1][2], 8);
}

}  // namespace
}  // namespace cas::hils

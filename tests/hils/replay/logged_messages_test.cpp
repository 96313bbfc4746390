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

}  // namespace
}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/tlog_clock.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::Attitude;
using mavlink::common::Heartbeat;

constexpr std::uint64_t kNow_us = 1'794'000'000'000'000;
constexpr std::uint64_t kYear_us = 31'536'000'000'000;
constexpr std::uint64_t kHour_us = 3'600'000'000;

/// A flight of 30 s at 10 Hz, each with a stamp of the recorder's clock.
struct ClockCase {
  const char* name;
  std::function<std::uint64_t(std::uint64_t)> stamp;
  std::int64_t slack_us;  ///< that a step of the clock may cost
  std::uint64_t steps;
};

class TlogClockCases : public testing::TestWithParam<ClockCase> {
 protected:
  Encoder encode_packet_{{.system = 1, .component = 1}};
};

TEST_P(TlogClockCases, GivesTheTimeOfTheFlight) {
  TlogClock clock;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Attitude attitude{.time_boot_ms = static_cast<std::uint32_t>(5000 + 100 * i)};
    const std::uint64_t stamp = GetParam().stamp(i);
    clock.at(stamp, encode_packet_(Heartbeat{}));
    const std::int64_t at = clock.at(stamp, encode_packet_(attitude));
    ASSERT_NEAR(static_cast<double>(at), 1e5 * static_cast<double>(i), 1.0) << i;
  }
  EXPECT_EQ(clock.steps(), GetParam().steps);
}

TEST_P(TlogClockCases, NeedsNoClockOfTheVehicle) {
  if (GetParam().slack_us < 0) GTEST_SKIP() << "its stamps alone tell nothing";
  TlogClock clock;
  std::int64_t before = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const std::int64_t at = clock.at(GetParam().stamp(i), encode_packet_(Heartbeat{}));
    ASSERT_GE(at, before);
    ASSERT_LE(at - before, 100'000);
    before = at;
  }
  EXPECT_NEAR(static_cast<double>(before), 29.9e6, static_cast<double>(GetParam().slack_us));
}

std::uint64_t even(std::uint64_t i) { return kNow_us + 100'000 * i; }

INSTANTIATE_TEST_SUITE_P(
    Of, TlogClockCases,
    testing::Values(
        ClockCase{"EvenStamps", even, 0, 0},
        ClockCase{"NtpAfterTheEpoch",
                  [](std::uint64_t i) { return i < 100 ? 86'400'000'000 + 100'000 * i : even(i); },
                  100'000, 1},
        ClockCase{"SetBackAnHour",
                  [](std::uint64_t i) { return even(i) - (i < 100 ? 0 : kHour_us); }, 100'000, 1},
        ClockCase{"SetForthAnHour",
                  [](std::uint64_t i) { return even(i) + (i < 100 ? 0 : kHour_us); }, 100'000, 1},
        ClockCase{"AWrongFirstStamp",
                  [](std::uint64_t i) { return even(i) + (i == 0 ? 10 * kYear_us : 0); }, 100'000,
                  1},
        ClockCase{"AWrongStamp",
                  [](std::uint64_t i) { return i == 150 ? ~std::uint64_t{0} : even(i); }, 200'000,
                  2},
        ClockCase{"NoStamps", [](std::uint64_t) { return std::uint64_t{0}; }, -1, 0}),
    [](const auto& test) { return test.param.name; });

TEST(TlogClock, KeepsAPauseThatTheVehicleTellsOf) {
  Encoder encode_packet({.system = 1, .component = 1});
  TlogClock clock;
  clock.at(kNow_us, encode_packet(Attitude{.time_boot_ms = 1000}));
  EXPECT_EQ(clock.at(kNow_us + 60'000'000, encode_packet(Heartbeat{})), 0);
  EXPECT_EQ(clock.at(kNow_us + 60'010'000, encode_packet(Attitude{.time_boot_ms = 61'010})),
            60'010'000);
  EXPECT_EQ(clock.at(kNow_us + 60'020'000, encode_packet(Attitude{.time_boot_ms = 61'020})),
            60'020'000);
}

TEST(TlogClock, KeepsItsPaceWhereStampsJitterOrAVehicleStartsAgain) {
  Encoder encode_packet({.system = 1, .component = 1});
  TlogClock clock;
  EXPECT_EQ(clock.at(kNow_us, encode_packet(Attitude{.time_boot_ms = 90'000})), 0);
  EXPECT_EQ(clock.at(kNow_us + 20'000, encode_packet(Heartbeat{})), 20'000);
  EXPECT_EQ(clock.at(kNow_us + 15'000, encode_packet(Heartbeat{})), 20'000);
  EXPECT_EQ(clock.at(kNow_us + 40'000, encode_packet(Attitude{.time_boot_ms = 100})), 40'000);
  EXPECT_EQ(clock.at(kNow_us - kHour_us, encode_packet(Attitude{.time_boot_ms = 200})), 140'000);
}

}  // namespace
}  // namespace cas::mav::services

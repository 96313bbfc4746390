// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/line/line_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <vector>

#include "base/error.hpp"
#include "base/random.hpp"
#include "tests/support/refusal.hpp"

namespace cas::fcu {
namespace {

using namespace std::chrono_literals;
using base::Duration;
using base::RunTime;

constexpr RunTime kStart{Duration(1'000'000'000)};

std::vector<std::uint8_t> bytes(std::size_t n) {
  std::vector<std::uint8_t> out(n);
  std::iota(out.begin(), out.end(), std::uint8_t{0});
  return out;
}

/// Time from a write to the last of its bytes.
Duration crossing_time(LineModel& line, std::size_t n, RunTime at) {
  line.write(bytes(n), at);
  RunTime last = at;
  std::vector<std::uint8_t> out(4096);
  while (const auto next = line.next_arrival()) {
    last = *next;
    line.read(out, last);
  }
  return last - at;
}

TEST(LineModel, IdealLineDeliversAtOnce) {
  LineModel line({}, 1);
  line.write(bytes(72), kStart);
  std::vector<std::uint8_t> out(100);
  EXPECT_EQ(line.read(out, kStart), 72U);
  out.resize(72);
  EXPECT_EQ(out, bytes(72));
}

TEST(LineModel, SeventyTwoBytesAt921600BaudTake781Microseconds) {
  LineModel line(LineConfig::from_preset("baud_921600"), 1);
  EXPECT_NEAR(base::to_seconds(crossing_time(line, 72, kStart)), 781.25e-6, 0.1e-6);
}

TEST(LineModel, AnIdleLineSavesUpNoCredit) {
  LineModel line(LineConfig::from_preset("baud_921600"), 1);
  crossing_time(line, 72, kStart);
  EXPECT_NEAR(base::to_seconds(crossing_time(line, 72, kStart + 1s)), 781.25e-6, 0.1e-6);
}

TEST(LineModel, BytesArriveOneByOne) {
  LineConfig config;
  config.baud = 10'000;  // 1 ms a byte
  LineModel line(config, 1);
  line.write(bytes(10), kStart);
  std::vector<std::uint8_t> out(100);
  EXPECT_EQ(line.read(out, kStart + 999us), 0U);
  EXPECT_EQ(line.read(out, kStart + 3500us), 3U);
  EXPECT_EQ(line.read(out, kStart + 10ms), 7U);
}

TEST(LineModel, WritesFollowEachOtherOnABusyLine) {
  LineConfig config{.baud = 10'000};
  LineModel line(config, 1);
  line.write(bytes(5), kStart);
  EXPECT_NEAR(base::to_seconds(crossing_time(line, 5, kStart + 1ms)), 9e-3, 1e-6);
}

TEST(LineModel, ReceiverAtTheSameRateReadsEveryByte) {
  for (unsigned value = 0; value < 256; ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    EXPECT_EQ(read_at_other_rate(byte, 1), byte);
    // Half a bit of error at the stop bit, which is looked at after 9.5 bit times, is 5 %.
    EXPECT_EQ(read_at_other_rate(byte, 1.04), byte);
    EXPECT_EQ(read_at_other_rate(byte, 0.96), byte);
  }
}

TEST(LineModel, ReceiverAtHalfTheRateReadsEverySecondBit) {
  // Its bit k is looked at 2 (k + 1.5) bit times behind the edge: at data bits 2, 4, 6, then idle.
  EXPECT_EQ(read_at_other_rate(0x00, 2), 0xF8);
  EXPECT_EQ(read_at_other_rate(0x05, 2), std::nullopt);  // data bit 0 is where a start bit must be
}

TEST(LineModel, ReceiverAtTwiceTheRateReadsTheFirstBitsTwice) {
  // Looked at after 0.75, 1.25, ... 4.25 bit times, the stop bit after 4.75.
  EXPECT_EQ(read_at_other_rate(0x0F, 0.5), 0xFE);
  EXPECT_EQ(read_at_other_rate(0x00, 0.5), std::nullopt);  // data bit 3 is no stop bit
}

TEST(LineModel, AnotherRateLosesAndChangesBytes) {
  LineConfig config{.baud = 921600, .receiver_baud = 460800};
  LineModel line(config, 1);
  line.write(bytes(200), kStart);
  std::vector<std::uint8_t> out(400);
  EXPECT_EQ(line.read(out, kStart + 1s) + line.stats().lost, 200U);
  EXPECT_GT(line.stats().lost, 50U);
  EXPECT_GT(line.stats().misread, 50U);
}

TEST(LineModel, DuplicatesAndReordersWholeWrites) {
  LineConfig config{.packet_duplicate = 1};
  LineModel twice(config, 1);
  twice.write(bytes(3), kStart);
  std::vector<std::uint8_t> out(100);
  EXPECT_EQ(twice.read(out, kStart), 6U);
  out.resize(6);
  EXPECT_EQ(out, (std::vector<std::uint8_t>{0, 1, 2, 0, 1, 2}));

  config.packet_duplicate = 0;
  config.packet_reorder = 1;
  LineModel crossed(config, 1);
  crossed.write(bytes(2), kStart);
  out.resize(100);
  EXPECT_EQ(crossed.read(out, kStart), 0U);
  const std::vector<std::uint8_t> next{7, 8, 9};
  crossed.configure({});
  crossed.write(next, kStart);
  EXPECT_EQ(crossed.read(out, kStart), 5U);
  out.resize(5);
  EXPECT_EQ(out, (std::vector<std::uint8_t>{7, 8, 9, 0, 1}));
}

TEST(LineModel, AWriteThatNoneFollowsComesAfterABoundedTime) {
  LineConfig config{.packet_reorder = 1};
  LineModel line(config, 1);
  EXPECT_EQ(crossing_time(line, 3, kStart), 50ms);
  EXPECT_EQ(line.stats().delivered, 3U);
  EXPECT_FALSE(line.next_arrival().has_value());
}

TEST(LineModel, ReordersAndDuplicatesTheShareOfWritesThatIsAskedFor) {
  constexpr int kWrites = 10'000;
  LineConfig config{
      .burst_begin = 0.01, .burst_end = 0.5, .packet_duplicate = 0.2, .packet_reorder = 0.3};
  LineModel line(config, 3);
  std::vector<std::uint8_t> out(4 * kWrites);
  for (int i = 0; i < kWrites; ++i) line.write(bytes(1), kStart);
  line.read(out, kStart + 1s);
  const LineModel::Stats& s = line.stats();
  EXPECT_EQ(s.written, static_cast<std::uint64_t>(kWrites));
  EXPECT_EQ(s.written + s.duplicated, s.delivered + s.lost);
  EXPECT_NEAR(static_cast<double>(s.duplicated) / kWrites, 0.2, 0.02);  // five deviations

  // A write is passed by the next one, or it is not: the order of two tells.
  config = {};
  config.packet_reorder = 0.3;
  int passed = 0;
  LineModel crossed(config, 4);
  for (int i = 0; i < kWrites; ++i) {
    const RunTime at = kStart + i * 1s;
    crossed.configure(config);
    crossed.write(std::vector<std::uint8_t>{1}, at);
    crossed.configure({});
    crossed.write(std::vector<std::uint8_t>{2}, at);
    ASSERT_EQ(crossed.read(out, at), 2U);
    passed += out[0] == 2 ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(passed) / kWrites, 0.3, 0.025);
}

TEST(LineModel, ARateThatIsNoneReadsAnIdleLine) {
  EXPECT_EQ(read_at_other_rate(0x00, 1e300), std::nullopt);
}

TEST(LineModel, ASlowClockStretchesTheBytes) {
  LineConfig config{.baud = 100'000, .clock_drift_ppm = 10'000};
  LineModel line(config, 1);
  EXPECT_NEAR(base::to_seconds(crossing_time(line, 100, kStart)), 10.1e-3, 1e-6);
}

TEST(LineModel, HoldsTheWriterBackWhenItsBufferIsFull) {
  LineConfig config{.baud = 10'000, .send_buffer_bytes = 8};
  LineModel line(config, 1);
  EXPECT_EQ(line.write(bytes(20), kStart), 8U);
  EXPECT_EQ(line.room(kStart), 0U);
  EXPECT_EQ(line.write(bytes(1), kStart), 0U);
  ASSERT_TRUE(line.room_at(kStart).has_value());
  EXPECT_EQ(*line.room_at(kStart), kStart + 1ms);
  EXPECT_EQ(line.write(bytes(20), kStart + 3ms), 3U);
  EXPECT_EQ(line.stats().refused, 12U + 1U + 17U);
}

TEST(LineModel, LosesWhatOverrunsTheReceiver) {
  LineConfig config{.baud = 10'000, .receive_fifo_bytes = 4};
  LineModel line(config, 1);
  line.write(bytes(10), kStart);
  std::vector<std::uint8_t> out(100);
  EXPECT_EQ(line.read(out, kStart + 7ms), 4U);
  EXPECT_EQ(out[3], 3);
  EXPECT_EQ(line.read(out, kStart + 10ms), 3U);
  EXPECT_EQ(out[0], 7);
  EXPECT_EQ(line.stats().overrun, 3U);
}

TEST(LineModel, UsbDeliversOnMillisecondFrames) {
  LineModel line(LineConfig::from_preset("usb"), 1);
  line.write(bytes(72), kStart + 300us);
  EXPECT_EQ(*line.next_arrival(), kStart + 1ms);
}

TEST(LineModel, DelaysAndJittersWithinBoundsAndInOrder) {
  LineConfig config{.extra_delay = 10ms, .jitter = 5ms};
  LineModel line(config, 3);
  RunTime before{};
  Duration least = 1s, most{};
  for (int i = 0; i < 500; ++i) {
    const RunTime at = kStart + i * 20ms;
    line.write(bytes(1), at);
    const RunTime arrival = *line.next_arrival();
    EXPECT_GE(arrival, before);
    before = arrival;
    least = std::min(least, arrival - at);
    most = std::max(most, arrival - at);
    std::vector<std::uint8_t> out(10);
    line.read(out, arrival);
  }
  EXPECT_GE(least, 10ms);
  EXPECT_LE(most, 15ms);
  EXPECT_GT(most - least, 4ms);
}

TEST(LineModel, FlipsBitsAtTheGivenRate) {
  LineConfig config{.bit_error_rate = 1e-3};
  LineModel line(config, 5);
  const std::vector<std::uint8_t> zeros(1000, 0);
  std::vector<std::uint8_t> out(1000);
  std::size_t flipped = 0;
  for (int i = 0; i < 100; ++i) {
    line.write(zeros, kStart);
    line.read(out, kStart);
    for (const std::uint8_t b : out) flipped += static_cast<std::size_t>(std::popcount(b));
  }
  // 800 000 bits: 800 expected, deviation 28.
  EXPECT_NEAR(static_cast<double>(flipped), 800, 120);
  EXPECT_EQ(line.stats().flipped, flipped);
}

TEST(LineModel, LosesBytesInBursts) {
  LineConfig config{.burst_begin = 0.001};
  config.burst_end = 0.05;  // 20 bytes on average
  LineModel line(config, 9);
  std::vector<std::uint8_t> out(1 << 20);
  std::size_t arrived = 0;
  for (int i = 0; i < 200; ++i) {
    line.write(bytes(1000), kStart);
    arrived += line.read(out, kStart);
  }
  const double share = 1 - static_cast<double>(arrived) / 200'000;
  EXPECT_NEAR(share, 0.001 / (0.001 + 0.05), 0.005);
  EXPECT_EQ(line.stats().lost + arrived, 200'000U);
}

TEST(LineModel, StallsAndCatchesUp) {
  LineConfig config{.stall_every = 100ms, .stall_length = 20ms};
  LineModel line(config, 11);
  int late = 0;
  for (int i = 0; i < 5000; ++i) {
    const RunTime at = kStart + i * 2ms;
    if (crossing_time(line, 1, at) > 1ms) ++late;
  }
  // A sixth of the time, as 20 ms follow 100 ms of flow.
  EXPECT_NEAR(late / 5000.0, 1.0 / 6, 0.04);
}

TEST(LineModel, HangingUpLosesWhatIsUnderWayAndTakesNothing) {
  LineModel line(LineConfig::from_preset("baud_115200"), 1);
  line.write(bytes(50), kStart);
  line.hang_up();
  EXPECT_EQ(line.write(bytes(50), kStart), 0U);
  EXPECT_FALSE(line.next_arrival().has_value());
  line.restore();
  EXPECT_EQ(line.write(bytes(50), kStart), 50U);
}

TEST(LineModel, SameSeedAndCallsGiveTheSameBytesAtTheSameTimes) {
  LineConfig config = LineConfig::from_preset("baud_460800");
  config.jitter = 3ms;
  config.bit_error_rate = 1e-3;
  config.packet_loss = 0.1;
  LineModel a(config, 21);
  LineModel b(config, 21);
  std::vector<std::uint8_t> out_a(4096), out_b(4096);
  for (int i = 0; i < 300; ++i) {
    const RunTime at = kStart + i * 2ms;
    a.write(bytes(60), at);
    b.write(bytes(60), at);
    ASSERT_EQ(a.next_arrival(), b.next_arrival());
    const std::size_t n = a.read(out_a, at);
    ASSERT_EQ(n, b.read(out_b, at));
    ASSERT_TRUE(
        std::equal(out_a.begin(), out_a.begin() + static_cast<std::ptrdiff_t>(n), out_b.begin()));
  }
}

/// Behaviour of a line over a second of writes and reads, as numbers that show any difference.
std::vector<std::int64_t> course(const LineConfig& config) {
  const auto count = [](std::optional<RunTime> t) {
    return t ? t->time_since_epoch().count() : -1;
  };
  LineModel line(config, 1);
  base::NormalRandom draw(2);
  std::vector<std::int64_t> course;
  std::vector<std::uint8_t> out(300);
  RunTime now{};
  for (int i = 0; i < 2000; ++i) {
    now += Duration(static_cast<Duration::rep>(draw.uniform() * 1e6));
    if (i % 3 == 0) {
      const auto size = static_cast<std::size_t>(1 + draw.uniform() * 120);
      course.push_back(static_cast<std::int64_t>(line.write(bytes(size), now)));
    } else {
      const std::size_t size = line.read(out, now);
      course.insert(course.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size));
    }
    course.push_back(count(line.next_arrival()));
    course.push_back(static_cast<std::int64_t>(line.room(now)));
    course.push_back(count(line.room_at(now)));
  }
  course.push_back(static_cast<std::int64_t>(line.stats().overrun));
  return course;
}

TEST(LineModel, BytesThatGoTogetherGoAsEachWouldAlone) {
  LineConfig uart = LineConfig::from_preset("baud_115200");
  uart.send_buffer_bytes = 200;
  uart.receive_fifo_bytes = 60;
  uart.receive_trigger_bytes = 16;
  LineConfig late = LineConfig::from_preset("ideal");
  late.extra_delay = 700us;
  late.batch = 250us;
  for (LineConfig line : {uart, late, LineConfig::from_preset("usb")}) {
    const std::vector<std::int64_t> together = course(line);
    line.burst_begin = 1e-300;  // never begins, but is drawn for each byte
    EXPECT_EQ(course(line), together) << line.preset;
  }
}

TEST(LineConfig, NamesTheKnownPresetsWhenOneIsUnknown) {
  const std::string said = cas::test::refusal([] { LineConfig::from_preset("rs485"); });
  EXPECT_NE(said.find("baud_921600"), std::string::npos) << said;
}

TEST(LineConfig, OverridesAPresetKeyByKey) {
  const LineConfig line = LineConfig::parse(
      base::ConfigNode::parse("{preset: baud_921600, extra_delay_us: 250, packet_loss: 0.01}"));
  EXPECT_EQ(line.baud, 921600);
  EXPECT_EQ(line.extra_delay, Duration(250us));
  EXPECT_EQ(line.packet_loss, 0.01);
  EXPECT_THROW(LineConfig::parse(base::ConfigNode::parse("{bauds: 3}")), base::ConfigError);
  EXPECT_THROW(LineConfig::parse(base::ConfigNode::parse("{baud: 9600, receiver_baud: 1e-9}")),
               base::ConfigError);
}

}  // namespace
}  // namespace cas::fcu

// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/tlog.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>

#include "mavlink/common/all.hpp"

namespace cas::mav::services {
namespace {

using mavlink::common::Attitude;
using mavlink::common::Heartbeat;

/// A log of three packets; the stamps look like starts of packets.
std::vector<std::uint8_t> three_records() {
  Encoder encode_packet({.system = 1, .component = 1});
  std::vector<std::uint8_t> log;
  append_tlog_record(0xFEFDFE, encode_packet(Heartbeat{}), log);
  append_tlog_record(0xFDFDFD, encode_packet(Attitude{.time_boot_ms = 5, .roll = 0.5F}), log);
  append_tlog_record(1'764'000'000'250'000, encode_packet(Attitude{.time_boot_ms = 6}), log);
  return log;
}

std::vector<std::uint64_t> stamps_of(TlogSplitter& splitter) {
  std::vector<std::uint64_t> stamps;
  while (const auto record = splitter.next(true)) stamps.push_back(record->unix_us);
  return stamps;
}

TEST(Tlog, ReadsBackWhatIsWritten) {
  TlogSplitter splitter;
  splitter.feed(three_records());
  std::vector<std::uint64_t> stamps;
  std::vector<std::uint32_t> boot_times;
  for_each_tlog_packet([&] { return splitter.next(true); }, mavlink::common::table(),
                       [&](std::uint64_t unix_us, const PacketView& packet) {
                         stamps.push_back(unix_us);
                         const auto attitude = decode<Attitude>(packet);
                         if (attitude) boot_times.push_back(attitude->time_boot_ms);
                       });
  EXPECT_EQ(stamps, (std::vector<std::uint64_t>{0xFEFDFE, 0xFDFDFD, 1'764'000'000'250'000}));
  EXPECT_EQ(boot_times, (std::vector<std::uint32_t>{5, 6}));
  EXPECT_EQ(splitter.skipped_bytes(), 0U);
}

TEST(Tlog, GivesTheSameWhateverPiecesItIsReadIn) {
  const std::vector<std::uint8_t> log = three_records();
  TlogSplitter splitter;
  std::vector<std::uint64_t> stamps;
  for (const std::uint8_t byte : log) {
    splitter.feed({&byte, 1});
    while (const auto record = splitter.next()) stamps.push_back(record->unix_us);
  }
  std::ranges::copy(stamps_of(splitter), std::back_inserter(stamps));
  EXPECT_EQ(stamps, (std::vector<std::uint64_t>{0xFEFDFE, 0xFDFDFD, 1'764'000'000'250'000}));
}

TEST(Tlog, SkipsWhatIsNoRecord) {
  std::vector<std::uint8_t> log(100, 0);
  std::ranges::copy(three_records(), std::back_inserter(log));
  TlogSplitter splitter;
  splitter.feed(log);
  EXPECT_EQ(stamps_of(splitter).size(), 3U);
  EXPECT_EQ(splitter.skipped_bytes(), 100U);
}

TEST(Tlog, ARecordThatWasCutOffIsNone) {
  std::vector<std::uint8_t> log = three_records();
  log.pop_back();
  TlogSplitter splitter;
  splitter.feed(log);
  EXPECT_EQ(stamps_of(splitter).size(), 2U);
}

/// Sixty records, 20 ms apart. 2026-09-21: the stamps begin 00 06 5b FE; in November 00 06 5f.
class DamagedTlog : public testing::TestWithParam<std::uint64_t> {
 protected:
  static constexpr std::uint32_t kRecords = 60;

  DamagedTlog() {
    Encoder encode_packet({.system = 1, .component = 1});
    for (std::uint32_t i = 0; i < kRecords; ++i) {
      records_.emplace_back();
      append_tlog_record(GetParam() + 20'000 * i,
                         encode_packet(Attitude{.time_boot_ms = i, .roll = 0.25F}),
                         records_.back());
    }
  }

  /// The numbers of the intact records that are found.
  std::vector<std::uint32_t> found() {
    std::vector<std::uint8_t> log;
    for (const auto& record : records_) std::ranges::copy(record, std::back_inserter(log));
    TlogSplitter splitter(&mavlink::common::table());
    splitter.feed(log);
    std::vector<std::uint32_t> numbers;
    for_each_tlog_packet([&] { return splitter.next(true); }, mavlink::common::table(),
                         [&](std::uint64_t unix_us, const PacketView& packet) {
                           numbers.push_back(decode<Attitude>(packet)->time_boot_ms);
                           EXPECT_EQ(unix_us, GetParam() + 20'000 * numbers.back());
                         });
    return numbers;
  }

  static std::vector<std::uint32_t> all_but(std::optional<std::uint32_t> lost) {
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < kRecords; ++i) {
      if (i != lost) numbers.push_back(i);
    }
    return numbers;
  }

  std::vector<std::vector<std::uint8_t>> records_;
};

TEST_P(DamagedTlog, ACutRecordCostsNoOtherOne) {
  for (const std::size_t bytes : {3U, 11U, 20U, 27U}) {
    const std::vector<std::uint8_t> whole = records_[30];
    records_[30].resize(bytes);
    EXPECT_EQ(found(), all_but(30)) << bytes;
    records_[30] = whole;
  }
}

TEST_P(DamagedTlog, AWrongLengthCostsNoOtherOne) {
  const std::uint8_t right = records_[30][9];
  for (const int wrong : {0, 1, right - 1, right + 1, 200, 255}) {
    records_[30][9] = static_cast<std::uint8_t>(wrong);
    EXPECT_EQ(found(), all_but(30)) << wrong;
  }
}

TEST_P(DamagedTlog, AFlippedBitCostsNoOtherOne) {
  for (std::size_t at = kTlogStampBytes; at < records_[30].size(); ++at) {
    records_[30][at] ^= 0x10U;
    EXPECT_EQ(found(), all_but(30)) << at;
    records_[30][at] ^= 0x10U;
  }
}

TEST_P(DamagedTlog, ZerosBetweenRecordsCostNone) {
  std::vector<std::uint8_t> zeros(4096, 0);
  std::ranges::copy(records_[30], std::back_inserter(zeros));
  records_[30] = zeros;
  EXPECT_EQ(found(), all_but(std::nullopt));
  for (auto& record : records_) record.resize(std::max<std::size_t>(record.size(), 288));
  EXPECT_EQ(found(), all_but(std::nullopt)) << "of a fixed size, filled with zeros";
}

INSTANTIATE_TEST_SUITE_P(Of, DamagedTlog,
                         testing::Values(1'794'000'000'000'000ULL, 1'790'000'000'000'000ULL,
                                         1'789'000'000'000'000ULL),
                         [](const auto& test) { return "Stamp" + std::to_string(test.param); });

}  // namespace
}  // namespace cas::mav::services

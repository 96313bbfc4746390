// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/tlog.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

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

}  // namespace
}  // namespace cas::mav::services

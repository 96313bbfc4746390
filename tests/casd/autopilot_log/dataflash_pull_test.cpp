// SPDX-License-Identifier: BSD-3-Clause
// ArduPilot's log from its link: the order of blocks, and the requests.
#include "casd/autopilot_log/dataflash_pull.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>

#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Status = RemoteLogBlockStatus;

constexpr base::RunTime kStart{seconds(100)};

/// A pull with a test in the place of casd.
struct Bench {
  DataflashPull pull{{.send =
                          [this](const VehicleCommander::LogAnswer& answer) {
                            said.push_back(std::get<RemoteLogBlockStatus>(answer));
                          },
                      .command = [](const VehicleCommand&, Done) { FAIL() << "no command"; },
                      .begin = [this](std::string_view) { ++began; },
                      .write =
                          [this](LogPart part) {
                            if (*part.at > file.size()) file.resize(*part.at);
                            EXPECT_EQ(*part.at, file.size());
                            file.insert(file.end(), part.bytes.begin(), part.bytes.end());
                            return true;
                          },
                      .end = [] {},
                      .warn = [](const std::string&) {}}};
  std::vector<RemoteLogBlockStatus> said;
  int began = 0;
  std::vector<std::uint8_t> file;
  mav::Encoder encoder{{1, 1}};

  void say(std::uint32_t number, base::RunTime now) {
    RemoteLogDataBlock block;
    block.seqno = number;
    block.data.fill(static_cast<std::uint8_t>(number + 1));
    pull.on_packet(mav::view_packet(encoder(block)), now);
  }
  std::size_t count(std::uint32_t number, std::uint8_t status) const {
    std::size_t n = 0;
    for (const auto& each : said) n += each.seqno == number && each.status == status ? 1 : 0;
    return n;
  }
  /// The first byte of each block of the file.
  std::vector<int> blocks() const {
    std::vector<int> all;
    for (std::size_t at = 0; at < file.size(); at += RemoteLogDataBlock::kBlockBytes) {
      all.push_back(file[at]);
    }
    return all;
  }
};

TEST(DataflashPull, OrdersTheLogUntilBlocksCome) {
  Bench bench;
  bench.pull.tick(kStart);
  EXPECT_EQ(bench.count(Status::kStop, Status::kAck), 1U) << "a log of before";
  for (int i = 0; i < 600; ++i) bench.pull.tick(kStart + i * milliseconds(50));
  EXPECT_EQ(bench.count(Status::kStart, Status::kAck), 6U) << "in 30 s";
  EXPECT_EQ(bench.count(Status::kStop, Status::kAck), 1U);
  bench.say(0, kStart + seconds(30));
  bench.pull.tick(kStart + seconds(31));
  EXPECT_EQ(bench.count(Status::kStart, Status::kAck), 6U);
  EXPECT_EQ(bench.began, 1);
}

TEST(DataflashPull, AcknowledgesEachBlockAndPutsThemInOrder) {
  Bench bench;
  bench.pull.tick(kStart);
  for (const std::uint32_t number : {0, 2, 3, 1, 1, 4}) bench.say(number, kStart);
  EXPECT_EQ(bench.blocks(), (std::vector<int>{1, 2, 3, 4, 5}));
  EXPECT_EQ(bench.count(1, Status::kAck), 2U) << "its acknowledgement may be lost";
  for (const std::uint32_t number : {0, 2, 3, 4}) EXPECT_EQ(bench.count(number, Status::kAck), 1U);
}

TEST(DataflashPull, AsksForABlockThatIsMissingAndGivesItUpInTheEnd) {
  Bench bench;
  bench.pull.tick(kStart);
  bench.say(0, kStart);
  bench.say(2, kStart);
  bench.pull.tick(kStart + milliseconds(50));
  EXPECT_EQ(bench.count(1, Status::kNack), 0U);
  bench.pull.tick(kStart + milliseconds(100));
  EXPECT_EQ(bench.count(1, Status::kNack), 1U);
  bench.pull.tick(kStart + milliseconds(150));
  EXPECT_EQ(bench.count(1, Status::kNack), 1U);
  EXPECT_EQ(bench.blocks(), std::vector<int>{1});
  bench.pull.tick(kStart + DataflashStream::kGiveUpAfter);
  EXPECT_EQ(bench.blocks(), (std::vector<int>{1, 0, 3})) << "zeros in its place";
}

TEST(DataflashPull, EndsALogWithoutBeginningAndOrdersAnother) {
  Bench bench;
  bench.pull.tick(kStart);
  const base::RunTime later = kStart + seconds(1);
  bench.say(50'000, later);
  EXPECT_EQ(bench.count(50'000, Status::kAck), 0U);
  EXPECT_EQ(bench.count(Status::kStop, Status::kAck), 2U);
  EXPECT_EQ(bench.count(Status::kStart, Status::kAck), 2U);
  for (int i = 0; i < 100; ++i) bench.say(50'001, later);
  EXPECT_EQ(bench.count(Status::kStop, Status::kAck), 2U) << "not for each block";
  EXPECT_EQ(bench.began, 0);
}

TEST(DataflashPull, ABlockFarAheadDoesNotGrowTheFile) {
  Bench bench;
  bench.pull.tick(kStart);
  bench.say(0, kStart);
  bench.say(4'000'000'000, kStart);
  EXPECT_EQ(bench.file.size(), RemoteLogDataBlock::kBlockBytes);
}

TEST(DataflashPull, ALogThatBeginsAnewAfterSilenceIsAnotherFile) {
  Bench bench;
  bench.pull.tick(kStart);
  for (std::uint32_t number = 0; number < 9; ++number) bench.say(number, kStart);
  const base::RunTime later = kStart + DataflashPull::kSilence + milliseconds(1);
  bench.pull.tick(later);
  bench.file.clear();
  bench.say(0, later);
  EXPECT_EQ(bench.began, 2);
  EXPECT_EQ(bench.blocks(), std::vector<int>{1});
}

}  // namespace
}  // namespace cas::casd

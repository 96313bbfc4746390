// SPDX-License-Identifier: BSD-3-Clause
// PX4's log from its link: handling of losses, and the requests.
#include "casd/autopilot_log/ulog_pull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "hils/ulog/read_ulog.hpp"
#include "mavlink/common/logging_data.hpp"
#include "mavlink/common/logging_data_acked.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/hils/ulog/ulog_bytes.hpp"

namespace cas::casd {
namespace {

using cas::test::UlogBytes;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kPieceBytes = 249;
constexpr base::RunTime kUlogStart{seconds(100)};

/// A log of one topic with so many messages, each with its number.
std::string log_of(int messages, std::uint64_t start_us = 1'000'000) {
  UlogBytes log(start_us);
  log.format("level:uint64_t timestamp;float value;").subscribe(3, "level");
  for (int i = 0; i < messages; ++i) {
    log.data(3, start_us + static_cast<std::uint64_t>(i) * 1000,
             UlogBytes::number(static_cast<float>(i)));
  }
  return log.bytes();
}

/// Where messages of a log begin; the header counts as one.
std::vector<std::size_t> beginnings(const std::string& log) {
  std::vector<std::size_t> all{0};
  for (std::size_t at = 16; at < log.size();) {
    all.push_back(at);
    at += 3 + static_cast<std::uint8_t>(log[at]) + 256U * static_cast<std::uint8_t>(log[at + 1]);
  }
  return all;
}

/// The log as PX4 cuts it.
std::vector<UlogStream::Piece> pieces_of(const std::string& log, std::uint16_t first = 0) {
  std::vector<UlogStream::Piece> pieces;
  const std::vector<std::size_t> begins = beginnings(log);
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(log.data());
  for (std::size_t at = 0; at < log.size(); at += kPieceBytes) {
    const std::size_t size = std::min(kPieceBytes, log.size() - at);
    const auto next = std::lower_bound(begins.begin(), begins.end(), at);
    const bool any = next != begins.end() && *next < at + size;
    pieces.push_back({static_cast<std::uint16_t>(first + pieces.size()),
                      any ? static_cast<std::uint8_t>(*next - at) : UlogStream::kNoMessage,
                      {bytes + at, size}});
  }
  return pieces;
}

/// Contents of the log as read by `hils replay`.
struct Found final : hils::UlogListener {
  explicit Found(const std::string& log) { hils::read_ulog(log, *this); }
  void on_message(const hils::UlogSeries& series, std::uint64_t, std::string_view bytes) override {
    values.push_back(hils::ulog_number(series.fields.at(0), bytes));
  }
  void on_dropout(int duration_ms) override { dropouts.push_back(duration_ms); }
  void on_damage(std::size_t bytes) override { damaged += bytes; }

  std::vector<double> values;
  std::vector<int> dropouts;
  std::size_t damaged = 0;
};

void append(std::string& file, const std::vector<std::uint8_t>& bytes) {
  file.append(bytes.begin(), bytes.end());
}

TEST(UlogStream, GivesTheLogAsItIs) {
  const std::string log = log_of(200);
  UlogStream stream;
  std::string file;
  for (const UlogStream::Piece& piece : pieces_of(log))
    append(file, stream.take(piece, kUlogStart));
  EXPECT_EQ(file, log);
}

TEST(UlogStream, MarksALossAsADropoutAndGoesOnAtTheNextMessage) {
  const std::string log = log_of(400);
  const auto pieces = pieces_of(log);
  UlogStream stream;
  std::string file;
  base::RunTime now = kUlogStart;
  for (const UlogStream::Piece& piece : pieces) {
    now += milliseconds(20);
    if (piece.sequence == 7 || piece.sequence == 8) continue;
    append(file, stream.take(piece, now));
  }
  const Found found(file);
  EXPECT_EQ(found.dropouts, std::vector<int>{60});
  EXPECT_EQ(found.damaged, 0U);
  EXPECT_LT(found.values.size(), 400U);
  // Two pieces are 29.3 messages of 17 bytes; each end cuts one more.
  EXPECT_GE(found.values.size(), 400U - 2 * kPieceBytes / 17 - 2);
  EXPECT_TRUE(std::is_sorted(found.values.begin(), found.values.end()));
  EXPECT_EQ(found.values.back(), 399);
}

TEST(UlogStream, TakesAPieceThatComesAgainOnce) {
  const std::string log = log_of(200);
  UlogStream stream;
  std::string file;
  for (const UlogStream::Piece& piece : pieces_of(log)) {
    append(file, stream.take(piece, kUlogStart));
    append(file, stream.take(piece, kUlogStart));
  }
  EXPECT_EQ(file, log);
}

TEST(UlogStream, CountsOnBeyondTheLargestSequence) {
  const std::string log = log_of(400);
  UlogStream stream;
  std::string file;
  for (const UlogStream::Piece& piece : pieces_of(log, 65530)) {
    append(file, stream.take(piece, kUlogStart));
  }
  EXPECT_EQ(file, log);
}

TEST(UlogStream, IsNothingBeforeTheHeader) {
  const std::string log = log_of(200);
  const auto pieces = pieces_of(log);
  UlogStream stream;
  EXPECT_TRUE(stream.take(pieces[1], kUlogStart).empty());
  EXPECT_FALSE(stream.began());
}

TEST(UlogStream, HoldsNoMoreThanOneMessageWhateverItsLengthSays) {
  UlogStream stream;
  const std::string log = log_of(1);
  stream.take(pieces_of(log)[0], kUlogStart);
  std::vector<std::uint8_t> noise(kPieceBytes, 0xFF);
  std::size_t out = 0;
  for (std::uint16_t i = 1; i < 2000; ++i) {
    out += stream.take({i, UlogStream::kNoMessage, noise}, kUlogStart).size();
  }
  const std::size_t in = 1999 * noise.size();
  EXPECT_GT(out + 70'000, in) << "what is not given out is kept";
}

/// A pull with a test in the place of casd.
struct UlogBench {
  UlogPull pull{{.send =
                     [this](const VehicleCommander::LogAnswer& said) {
                       acks.push_back(std::get<mavlink::common::LoggingAck>(said).sequence);
                     },
                 .command =
                     [this](const VehicleCommand& command, Done done) {
                       commands.push_back(command.id);
                       answer = std::move(done);
                     },
                 .begin = [this](std::string_view extension) { began.emplace_back(extension); },
                 .write =
                     [this](LogPart part) {
                       append(file, part.bytes);
                       return room;
                     },
                 .end = [this] { ++ended; },
                 .warn = [this](const std::string& text) { warnings.push_back(text); }}};
  std::vector<std::uint16_t> acks;
  std::vector<mavlink::common::MavCmd> commands;
  Done answer;
  std::vector<std::string> began;
  std::string file;
  int ended = 0;
  bool room = true;
  std::vector<std::string> warnings;
  mav::Encoder encoder{{1, 1}};

  template <class Message>
  void say(const UlogStream::Piece& piece, base::RunTime now) {
    Message message;
    message.target_system = 254;
    message.target_component = 190;
    message.sequence = piece.sequence;
    message.first_message_offset = piece.first_message;
    message.length = static_cast<std::uint8_t>(piece.data.size());
    std::copy(piece.data.begin(), piece.data.end(), message.data.begin());
    pull.on_packet(mav::view_packet(encoder(message)), now);
  }
  void say(const UlogStream::Piece& piece, base::RunTime now) {
    say<mavlink::common::LoggingData>(piece, now);
  }
  std::size_t starts() const {
    return static_cast<std::size_t>(
        std::count(commands.begin(), commands.end(), mavlink::common::MavCmd::kLoggingStart));
  }
};

Outcome refusal(mavlink::common::MavResult result) {
  Outcome outcome = failure(OutcomeKind::kRefused, "it was refused");
  outcome.result = result;
  return outcome;
}

TEST(UlogPull, AsksOnceAndAcknowledgesEachPieceThatWantsIt) {
  UlogBench bench;
  bench.pull.tick(kUlogStart);
  bench.pull.tick(kUlogStart + seconds(1));
  ASSERT_EQ(bench.starts(), 1U) << "the request is under way";
  bench.answer(Outcome{});
  const std::string log = log_of(20);
  const auto pieces = pieces_of(log);
  bench.say<mavlink::common::LoggingDataAcked>(pieces[0], kUlogStart);
  bench.say<mavlink::common::LoggingDataAcked>(pieces[0], kUlogStart);
  bench.say(pieces[1], kUlogStart);
  EXPECT_EQ(bench.acks, (std::vector<std::uint16_t>{0, 0}));
  EXPECT_EQ(bench.began, std::vector<std::string>{"ulg"});
  EXPECT_EQ(bench.file, log.substr(0, bench.file.size()));
  EXPECT_GT(bench.file.size(), kPieceBytes);
}

TEST(UlogPull, EndsALogOfBeforeThatRunsAndAsksAgain) {
  UlogBench bench;
  bench.pull.tick(kUlogStart);
  bench.answer(refusal(mavlink::common::MavResult::kTemporarilyRejected));
  EXPECT_EQ(bench.commands.back(), mavlink::common::MavCmd::kLoggingStop);
  EXPECT_TRUE(bench.warnings.empty());
  bench.pull.tick(kUlogStart + UlogPull::kFirstRetry);
  EXPECT_EQ(bench.commands.back(), mavlink::common::MavCmd::kLoggingStart);
}

TEST(UlogPull, TellsOnceWhyNothingComesAndAsksSeldom) {
  UlogBench bench;
  base::RunTime now = kUlogStart;
  for (int tick = 0; tick < 600; ++tick, now += milliseconds(500)) {
    bench.pull.tick(now);
    if (bench.answer) std::exchange(bench.answer, {})(refusal(mavlink::common::MavResult::kDenied));
  }
  EXPECT_EQ(bench.starts(), 5U) << "in five minutes";
  EXPECT_EQ(bench.warnings.size(), 1U);
}

TEST(UlogPull, AsksAgainAfterSilenceAndAfterARestart) {
  UlogBench bench;
  bench.pull.tick(kUlogStart);
  bench.answer(Outcome{});
  const std::string log = log_of(20);
  bench.say(pieces_of(log)[0], kUlogStart);
  bench.pull.tick(kUlogStart + UlogPull::kSilence);
  EXPECT_EQ(bench.starts(), 1U);
  base::RunTime now = kUlogStart + UlogPull::kSilence + milliseconds(1);
  bench.pull.tick(now);
  EXPECT_EQ(bench.starts(), 2U);
  const int ended = bench.ended;
  bench.pull.restart(now);
  EXPECT_EQ(bench.ended, ended + 1);
  bench.pull.tick(now);
  EXPECT_EQ(bench.starts(), 3U);
  EXPECT_NE(bench.commands.back(), mavlink::common::MavCmd::kLoggingStop) << "nothing runs there";
}

TEST(UlogPull, MakesNoFileForEachHeader) {
  UlogBench bench;
  bench.pull.tick(kUlogStart);
  bench.answer(Outcome{});
  base::RunTime now = kUlogStart;
  for (std::uint64_t i = 0; i < 1000; ++i, now += milliseconds(10)) {
    const std::string log = log_of(20, 1'000'000 + i);
    bench.say(pieces_of(log)[0], now);
  }
  EXPECT_EQ(bench.began.size(), 2U) << "in ten seconds";
}

TEST(UlogPull, EndsTheLogWhereTheDiskDoesNotKeepUp) {
  UlogBench bench;
  bench.pull.tick(kUlogStart);
  bench.answer(Outcome{});
  bench.room = false;
  const std::string log = log_of(20);
  bench.say(pieces_of(log)[0], kUlogStart);
  EXPECT_EQ(bench.commands.back(), mavlink::common::MavCmd::kLoggingStop);
  bench.pull.tick(kUlogStart + seconds(1));
  EXPECT_EQ(bench.starts(), 1U);
  bench.pull.tick(kUlogStart + UlogPull::kSilence);
  EXPECT_EQ(bench.starts(), 2U);
}

}  // namespace
}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/ftp_server.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/mavlink_gen/services/memory_ftp_store.hpp"

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
using mavlink::common::MavFtpErr;
using Opcode = mavlink::common::MavFtpOpcode;

constexpr Source kStation{255, 190};
constexpr Source kOther{254, 190};

/// A server on a virtual clock, with files "a" (1000 bytes) and "log/b".
class FtpServerTest : public testing::Test {
 protected:
  FtpServerTest() {
    for (int i = 0; i < 1000; ++i) store_.files["a"].push_back(static_cast<std::uint8_t>(i % 251));
    store_.files["log/b"] = {1, 2, 3};
  }
  /// @return the answer; one without an opcode when there was none
  FtpPayload ask(FtpPayload request, Source from = kStation) {
    request.seq = seq_ += 2;
    return ask_again(request, from);
  }
  FtpPayload ask_again(const FtpPayload& request, Source from = kStation) {
    sent_.clear();
    server_.on_request(ftp_message(request), from, now_);
    return sent_.empty() ? FtpPayload{} : sent_.back();
  }
  FtpPayload ask(Opcode opcode, const std::string& path, Source from = kStation) {
    FtpPayload request{.opcode = opcode};
    request.set_text(path);
    return ask(request, from);
  }
  /// Asks for a checksum with a number of the caller's.
  void request_sum(const std::string& path, int seq, Source from) {
    FtpPayload request{.seq = static_cast<std::uint16_t>(seq), .opcode = Opcode::kCalcfilecrc};
    request.set_text(path);
    server_.on_request(ftp_message(request), from, now_);
  }
  /// Error code of a refusal.
  static MavFtpErr error(const FtpPayload& answer) {
    EXPECT_EQ(answer.opcode, Opcode::kNak);
    return static_cast<MavFtpErr>(answer.data[0]);
  }
  FtpPayload read(std::uint8_t session, std::uint32_t offset, std::uint8_t size) {
    return ask({.session = session, .opcode = Opcode::kReadfile, .size = size, .offset = offset});
  }

  Time now_{1s};
  std::uint16_t seq_ = 100;
  MemoryFtpStore store_;
  std::vector<FtpPayload> sent_;
  std::vector<Source> to_;
  FtpServer::Send take_ = [this](const auto& message) {
    sent_.push_back(ftp_payload(message));
    to_.push_back({message.target_system, message.target_component});
    return packet_bytes_;
  };
  std::size_t packet_bytes_ = 100;  ///< that a packet takes of the line
  FtpServer server_{store_, take_};
};

TEST(FtpPath, LeadsNowhereButDown) {
  EXPECT_EQ(ftp_path("/"), "");
  EXPECT_EQ(ftp_path("//log/./b/"), "log/b");
  EXPECT_EQ(ftp_path("/etc/passwd"), "etc/passwd");
  EXPECT_EQ(ftp_path("log/..b"), "log/..b");
  EXPECT_EQ(ftp_path(".."), std::nullopt);
  EXPECT_EQ(ftp_path("log/../../etc"), std::nullopt);
  EXPECT_EQ(ftp_path("/../etc"), std::nullopt);
}

TEST(FtpPayloadBytes, StandWhereTheProtocolHasThem) {
  FtpPayload payload{.seq = 0x0201,
                     .session = 3,
                     .opcode = Opcode::kAck,
                     .size = 1,
                     .req_opcode = Opcode::kBurstreadfile,
                     .burst_complete = true,
                     .offset = 0x0D0C0B0A};
  payload.data[0] = 0xEE;
  payload.data[238] = 0xFF;
  const auto message = ftp_message(payload);
  const std::array<std::uint8_t, 13> head{1, 2, 3, 128, 1, 15, 1, 0, 0x0A, 0x0B, 0x0C, 0x0D, 0xEE};
  EXPECT_TRUE(std::equal(head.begin(), head.end(), message.payload.begin()));
  EXPECT_EQ(message.payload[250], 0xFF);
  EXPECT_EQ(ftp_payload(message), payload);
}

TEST(FtpPayloadBytes, ChecksumIsMavlinks) {
  const std::string digits = "123456789";
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size());
  EXPECT_EQ(ftp_crc32(bytes), 0x2DFD2D88U);  // reflected 0x04C11DB7, from 0, not inverted
  EXPECT_EQ(ftp_crc32(bytes.subspan(4), ftp_crc32(bytes.first(4))), 0x2DFD2D88U);
}

TEST_F(FtpServerTest, OpensReadsAndCloses) {
  const FtpPayload opened = ask(Opcode::kOpenfilero, "/a");
  EXPECT_EQ(opened.opcode, Opcode::kAck);
  EXPECT_EQ(opened.req_opcode, Opcode::kOpenfilero);
  EXPECT_EQ(opened.seq, seq_ + 1);
  EXPECT_EQ(opened.size, 4);
  EXPECT_EQ(opened.number(), 1000U);
  EXPECT_EQ(to_.back(), kStation);
  const FtpPayload end = read(opened.session, 900, 239);
  EXPECT_EQ(end.size, 100);
  EXPECT_EQ(end.data[0], 900 % 251);
  EXPECT_EQ(error(read(opened.session, 1000, 239)), MavFtpErr::kEof);
  EXPECT_EQ(sent_.back().size, 1);
  const FtpPayload close{.session = opened.session, .opcode = Opcode::kTerminatesession};
  EXPECT_EQ(ask(close).opcode, Opcode::kAck);
  EXPECT_EQ(error(ask(close)), MavFtpErr::kInvalidsession);
  EXPECT_EQ(error(read(opened.session, 0, 1)), MavFtpErr::kInvalidsession);
}

TEST_F(FtpServerTest, AnswersARepeatedRequestWithTheSameAnswer) {
  FtpPayload request{.seq = 9, .opcode = Opcode::kRemovefile};
  request.set_text("a");
  EXPECT_EQ(ask_again(request).opcode, Opcode::kAck);
  EXPECT_EQ(ask_again(request).opcode, Opcode::kAck);  // a second removal would fail
  request.seq = 11;
  EXPECT_EQ(error(ask_again(request)), MavFtpErr::kFilenotfound);
}

TEST_F(FtpServerTest, BurstsAtItsPaceToTheEnd) {
  FtpServer server(store_, take_, {.bytes_per_s = 10'000, .burst_packets = 3});
  FtpPayload request{.seq = 1, .opcode = Opcode::kOpenfilero};
  request.set_text("a");
  server.on_request(ftp_message(request), kStation, now_);
  ASSERT_EQ(sent_.size(), 1U);
  request = {
      .seq = 3, .session = sent_.back().session, .opcode = Opcode::kBurstreadfile, .size = 239};
  server.on_request(ftp_message(request), kStation, now_);
  sent_.clear();
  std::vector<std::size_t> by_then;
  for (int i = 0; i < 5; ++i) {
    now_ += 10ms;
    server.update(now_);
    by_then.push_back(sent_.size());
  }
  EXPECT_EQ(by_then, (std::vector<std::size_t>{1, 2, 3, 3, 3}));
  EXPECT_EQ(sent_[0].seq, 4);
  EXPECT_EQ(sent_[2].seq, 6);
  EXPECT_EQ(sent_[2].offset, 478U);
  EXPECT_FALSE(sent_[1].burst_complete);
  EXPECT_TRUE(sent_[2].burst_complete);
  request.seq = 7;
  request.offset = 717;
  server.on_request(ftp_message(request), kStation, now_);
  for (int i = 0; i < 5; ++i) server.update(now_ += 10ms);
  EXPECT_EQ(sent_[4].size, 44);
  EXPECT_EQ(error(sent_.back()), MavFtpErr::kEof);
  EXPECT_EQ(sent_.size(), 6U);
}

TEST_F(FtpServerTest, LongPacketsHaveTheNextOneWaitLonger) {
  FtpServer server(store_, take_, {.bytes_per_s = 10'000});
  packet_bytes_ = 250;
  server.on_request(ftp_message({.seq = 1}), kStation, now_);
  packet_bytes_ = 50;
  for (std::uint16_t i = 3; i < 9; i += 2) {
    server.on_request(ftp_message({.seq = i}), kStation, now_);
  }
  server.update(now_ + 24ms);
  EXPECT_EQ(sent_.size(), 1U);
  server.update(now_ + 40ms);  // late, and none is sent to catch up
  EXPECT_EQ(sent_.size(), 2U);
  server.update(now_ + 44ms);
  EXPECT_EQ(sent_.size(), 2U);
  server.update(now_ + 45ms);
  EXPECT_EQ(sent_.size(), 3U);
}

TEST_F(FtpServerTest, WithoutAPaceEachUpdateSendsAPacketOfABurst) {
  FtpServer server(store_, take_, {.burst_packets = 0});
  FtpPayload request{.seq = 1, .opcode = Opcode::kOpenfilero};
  request.set_text("a");
  server.on_request(ftp_message(request), kStation, now_);
  ask(Opcode::kOpenfilero, "a");
  FtpPayload burst{.session = sent_.back().session, .opcode = Opcode::kBurstreadfile};
  ask(burst);
  EXPECT_EQ(sent_.size(), 1U);
  server_.update(now_);
  EXPECT_EQ(sent_.size(), 2U);
  EXPECT_EQ(sent_.back().offset, 239U);
  burst.seq = 3;
  burst.session = 0;
  server.on_request(ftp_message(burst), kStation, now_);
  EXPECT_TRUE(sent_.back().burst_complete);  // no packets at all would be no answer
}

// Some clients take a short packet that ends a burst for the end of the file, and a short answer to
// a read for none.
TEST_F(FtpServerTest, ShortPiecesAreOfBurstsAloneAndDoNotEndThem) {
  FtpServer server(store_, take_, {.piece_bytes = 65, .burst_packets = 2});
  FtpPayload request{.seq = 1, .opcode = Opcode::kOpenfilero};
  request.set_text("a");
  server.on_request(ftp_message(request), kStation, now_);
  request = {.seq = 3, .session = sent_.back().session, .opcode = Opcode::kReadfile, .size = 80};
  server.on_request(ftp_message(request), kStation, now_);
  EXPECT_EQ(sent_.back().size, 80);
  request.seq = 5;
  request.opcode = Opcode::kBurstreadfile;
  sent_.clear();
  server.on_request(ftp_message(request), kStation, now_);
  for (int i = 0; i < 30; ++i) server.update(now_);
  ASSERT_EQ(sent_.size(), 17U);  // 15 * 65 + 25 bytes, and the end
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(sent_[i].offset, 65 * i);
    EXPECT_FALSE(sent_[i].burst_complete);
  }
  EXPECT_EQ(error(sent_.back()), MavFtpErr::kEof);
  EXPECT_TRUE(sent_.back().burst_complete);
}

TEST_F(FtpServerTest, OldAnswersAreForgotten) {
  FtpPayload request{.seq = 9, .opcode = Opcode::kListdirectory};
  request.set_text("log");
  const FtpPayload before = ask_again(request);
  store_.files["log/later"] = {1};
  now_ += 5s;
  EXPECT_EQ(ask_again(request), before);
  now_ += 1s;
  EXPECT_NE(ask_again(request), before);
}

TEST_F(FtpServerTest, LastFourAnswersAreKept) {
  FtpPayload request{.seq = 9, .opcode = Opcode::kRemovefile};
  request.set_text("a");
  EXPECT_EQ(ask_again(request).opcode, Opcode::kAck);
  for (int i = 0; i < 3; ++i) ask({.opcode = Opcode::kNone});
  for (int i = 0; i < 9; ++i) ask({.opcode = Opcode::kNone}, kOther);
  EXPECT_EQ(ask_again(request).opcode, Opcode::kAck);
  ask({.opcode = Opcode::kNone});
  EXPECT_EQ(error(ask_again(request)), MavFtpErr::kFilenotfound);
}

TEST_F(FtpServerTest, PagesOfAListAreShortAndComeFromOneListing) {
  FtpServer server(store_, take_, {.piece_bytes = 65});
  for (int i = 0; i < 50; ++i) store_.files["many/" + std::to_string(i)];
  store_.files["many/" + std::string(100, 'x')];
  FtpPayload request{.seq = 1, .opcode = Opcode::kListdirectory};
  request.set_text("many");
  for (int i = 0; i < 60 && (i == 0 || sent_.back().opcode == Opcode::kAck); ++i) {
    server.on_request(ftp_message(request), kStation, now_);
    const auto bytes = sent_.back().bytes();
    const auto entries = static_cast<std::uint32_t>(std::ranges::count(bytes, 0));
    EXPECT_TRUE(bytes.size() <= 65 || entries == 1) << bytes.size();
    if (sent_.back().opcode == Opcode::kAck) request.offset += entries;
    ++request.seq;
  }
  EXPECT_EQ(error(sent_.back()), MavFtpErr::kEof);
  EXPECT_EQ(request.offset, 51U);
  EXPECT_EQ(store_.listings, 1);
}

TEST_F(FtpServerTest, ListsFoldersFromAnEntryOn) {
  const FtpPayload first = ask(Opcode::kListdirectory, "/");
  EXPECT_EQ(std::string(first.data.begin(), first.data.begin() + first.size),
            std::string("Fa\t1000\0Dlog\0", 13));
  FtpPayload request{.opcode = Opcode::kListdirectory, .offset = 1};
  EXPECT_EQ(ask(request).text(), "Dlog");
  request.offset = 2;
  EXPECT_EQ(error(ask(request)), MavFtpErr::kEof);
  EXPECT_EQ(error(ask(Opcode::kListdirectory, "none")), MavFtpErr::kFilenotfound);
  EXPECT_EQ(error(ask(Opcode::kListdirectory, "log/..")), MavFtpErr::kFilenotfound);
}

TEST_F(FtpServerTest, SumsLongFilesInParts) {
  store_.files["long"].assign(200'000, 7);
  FtpPayload request{.seq = 5, .opcode = Opcode::kCalcfilecrc};
  request.set_text("long");
  ask_again(request);
  ask_again(request);  // again meanwhile: no second sum
  EXPECT_TRUE(sent_.empty());
  for (int i = 0; i < 4; ++i) server_.update(now_);
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].number(), ftp_crc32(store_.files["long"]));
  EXPECT_EQ(sent_[0].seq, 6);
}

TEST_F(FtpServerTest, ASumWaitsForAnothersAndLetsOtherRequestsPass) {
  store_.files["long"].assign(2'000'000, 7);
  request_sum("long", 5, kStation);
  request_sum("a", 7, kOther);
  request_sum("a", 7, kOther);  // again meanwhile: it waits once
  EXPECT_TRUE(sent_.empty());
  EXPECT_EQ(ask(Opcode::kOpenfilero, "a", kOther).opcode, Opcode::kAck);
  sent_.clear();
  to_.clear();
  for (int i = 0; i < 40; ++i) server_.update(now_);
  ASSERT_EQ(sent_.size(), 2U);
  EXPECT_EQ(to_[0], kStation);
  EXPECT_EQ(sent_[0].number(), ftp_crc32(store_.files["long"]));
  EXPECT_EQ(to_[1], kOther);
  EXPECT_EQ(sent_[1].number(), ftp_crc32(store_.files["a"]));
}

TEST_F(FtpServerTest, FourSumsMayWaitAndTheNextOneIsDropped) {
  store_.files["long"].assign(2'000'000, 7);
  for (int i = 0; i < 6; ++i) request_sum("long", 2 * i, kOther);
  EXPECT_EQ(server_.dropped(), 1U);
  for (int i = 0; i < 200; ++i) server_.update(now_);
  EXPECT_EQ(sent_.size(), 5U);
}

TEST_F(FtpServerTest, SumEndsWhereTheFileEndedAtFirst) {
  store_.files["long"].assign(200'000, 7);
  const std::uint32_t sum = ftp_crc32(store_.files["long"]);
  ask(Opcode::kCalcfilecrc, "long");
  store_.files["long"].assign(1'000'000, 7);
  for (int i = 0; i < 4; ++i) server_.update(now_);
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].number(), sum);
}

TEST_F(FtpServerTest, ResetEndsASumOfItsSender) {
  store_.files["long"].assign(2'000'000, 7);
  ask(Opcode::kCalcfilecrc, "long");
  request_sum("long", 100, kStation);  // one more, which waits
  ask({.opcode = Opcode::kResetsession}, kOther);
  request_sum("a", 7, kOther);
  sent_.clear();
  ask({.opcode = Opcode::kResetsession});
  ASSERT_EQ(sent_.size(), 2U) << "the reset, and the other's sum without a wait";
  EXPECT_EQ(sent_[1].number(), ftp_crc32(store_.files["a"]));
  for (int i = 0; i < 40; ++i) server_.update(now_);
  EXPECT_EQ(sent_.size(), 2U);
}

TEST_F(FtpServerTest, SessionsBelongToWhoOpenedThem) {
  const std::uint8_t session = ask(Opcode::kOpenfilero, "a").session;
  const FtpPayload close{.session = session, .opcode = Opcode::kTerminatesession};
  EXPECT_EQ(error(ask(close, kOther)), MavFtpErr::kInvalidsession);
  EXPECT_EQ(ask({.opcode = Opcode::kResetsession}, kOther).opcode, Opcode::kAck);
  EXPECT_EQ(read(session, 0, 1).opcode, Opcode::kAck);
  EXPECT_EQ(ask({.opcode = Opcode::kResetsession}).opcode, Opcode::kAck);
  EXPECT_EQ(error(read(session, 0, 1)), MavFtpErr::kInvalidsession);
}

TEST_F(FtpServerTest, ClientThatCountsItsSessionsGetsTheNumberThatItNames) {
  const auto open = [&](std::uint8_t session, Source from = kStation) {
    FtpPayload request{.session = session, .opcode = Opcode::kOpenfilero};
    request.set_text("a");
    const FtpPayload opened = ask(request, from);
    EXPECT_EQ(opened.opcode, Opcode::kAck);
    return opened.session;
  };
  for (const std::uint8_t session :
       std::array<std::uint8_t, 5>{0, 1, 2, 0, 1}) {  // started a second time
    EXPECT_EQ(open(session), session);
    EXPECT_EQ(read(session, 0, 3).opcode, Opcode::kAck);
    EXPECT_EQ(ask({.session = session, .opcode = Opcode::kTerminatesession}).opcode, Opcode::kAck);
  }
  EXPECT_EQ(open(7), 7);
  EXPECT_EQ(open(7), 7) << "its close was lost";
  EXPECT_EQ(open(7, kOther), 7) << "another client's";
  EXPECT_EQ(open(0), 0);
  EXPECT_EQ(open(0), 1) << "a client that takes the answer's number opens a second file";
  EXPECT_EQ(read(0, 0, 1).opcode, Opcode::kAck);
  EXPECT_EQ(read(1, 0, 1).opcode, Opcode::kAck);
}

TEST_F(FtpServerTest, SessionsAreFewAndIdleOnesAreTaken) {
  const std::uint8_t oldest = ask(Opcode::kOpenfilero, "a").session;
  now_ += 1ms;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ask(Opcode::kOpenfilero, "a").opcode, Opcode::kAck);
  EXPECT_EQ(error(ask(Opcode::kOpenfilero, "a", kOther)), MavFtpErr::kNosessionsavailable);
  now_ += 31s;
  EXPECT_EQ(error(ask(Opcode::kOpenfilero, "none", kOther)), MavFtpErr::kFilenotfound);
  EXPECT_EQ(read(oldest, 0, 1).opcode,
            Opcode::kAck);  // it is not lost for a file that is not there
  EXPECT_EQ(ask(Opcode::kOpenfilero, "a", kOther).opcode, Opcode::kAck);
}

TEST_F(FtpServerTest, RefusesInTheProtocolsWords) {
  EXPECT_EQ(error(ask(Opcode::kOpenfilero, "none")), MavFtpErr::kFilenotfound);
  EXPECT_EQ(error(ask(Opcode::kOpenfilero, "../a")), MavFtpErr::kFilenotfound);
  EXPECT_EQ(error(ask(Opcode::kCalcfilecrc, "../a")), MavFtpErr::kFilenotfound);
  EXPECT_EQ(error(ask(Opcode::kRemovefile, "../a")), MavFtpErr::kFilenotfound);
  EXPECT_EQ(error(ask(Opcode::kCreatefile, "protected")), MavFtpErr::kFileprotected);
  EXPECT_EQ(error(ask(Opcode::kRename, "a")), MavFtpErr::kUnknowncommand);
  EXPECT_EQ(error(ask({.opcode = static_cast<Opcode>(77)})), MavFtpErr::kUnknowncommand);
  EXPECT_EQ(error(ask({.opcode = Opcode::kOpenfilero, .size = 240})), MavFtpErr::kInvaliddatasize);
  const std::uint8_t reading = ask(Opcode::kOpenfilero, "a").session;
  EXPECT_EQ(error(ask({.session = reading, .opcode = Opcode::kWritefile, .size = 1})),
            MavFtpErr::kFileprotected);
  const std::uint8_t full = ask(Opcode::kCreatefile, "full").session;
  EXPECT_EQ(error(ask({.session = full, .opcode = Opcode::kWritefile, .size = 1})),
            MavFtpErr::kFailerrno);
  EXPECT_EQ(sent_.back().size, 2);
  EXPECT_EQ(sent_.back().data[1], 28);
}

TEST_F(FtpServerTest, AnswersAreNoRequestsAndTooManyAreDropped) {
  ask({.opcode = Opcode::kAck});
  EXPECT_TRUE(sent_.empty());
  FtpServer slow(store_, take_, {.bytes_per_s = 100});
  for (std::uint16_t i = 0; i < 100; ++i) {
    slow.on_request(ftp_message({.seq = i, .opcode = Opcode::kNone}), kStation, now_);
  }
  EXPECT_EQ(sent_.size(), 1U);
  EXPECT_EQ(slow.dropped(), 83U);
}

}  // namespace
}  // namespace cas::mav::services

// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/ftp_server.hpp"

#include <gtest/gtest.h>

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
  /// What a refusal says.
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
  FtpServer server_{store_, [this](const auto& message) {
                      sent_.push_back(ftp_payload(message));
                      to_.push_back({message.target_system, message.target_component});
                    }};
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
  FtpServer server(store_, [this](const auto& m) { sent_.push_back(ftp_payload(m)); },
                   {.interval = 10ms, .burst_packets = 3});
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

TEST_F(FtpServerTest, ListsFoldersFromAnEntryOn) {
  const FtpPayload first = ask(Opcode::kListdirectory, "/");
  EXPECT_EQ(std::string(first.data.begin(), first.data.begin() + first.size),
            std::string("Fa\t1000\0Dlog\0", 13));
  FtpPayload request{.opcode = Opcode::kListdirectory, .offset = 2};
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
  EXPECT_EQ(error(ask(Opcode::kCalcfilecrc, "a", kOther)), MavFtpErr::kFail);
  sent_.clear();
  for (int i = 0; i < 4; ++i) server_.update(now_);
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].number(), ftp_crc32(store_.files["long"]));
  EXPECT_EQ(sent_[0].seq, 6);
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

TEST_F(FtpServerTest, SessionsAreFewAndIdleOnesAreTaken) {
  for (int i = 0; i < 4; ++i) EXPECT_EQ(ask(Opcode::kOpenfilero, "a").opcode, Opcode::kAck);
  EXPECT_EQ(error(ask(Opcode::kOpenfilero, "a", kOther)), MavFtpErr::kNosessionsavailable);
  now_ += 31s;
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
  FtpServer slow(store_, [this](const auto& m) { sent_.push_back(ftp_payload(m)); },
                 {.interval = 1s});
  for (std::uint16_t i = 0; i < 100; ++i) {
    slow.on_request(ftp_message({.seq = i, .opcode = Opcode::kNone}), kStation, now_);
  }
  EXPECT_EQ(sent_.size(), 2U);
  EXPECT_EQ(slow.dropped(), 82U);
}

}  // namespace
}  // namespace cas::mav::services

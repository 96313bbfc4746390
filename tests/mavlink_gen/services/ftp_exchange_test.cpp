// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/ftp_exchange.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <random>

#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/services/address.hpp"
#include "tests/mavlink_gen/services/memory_ftp_store.hpp"

namespace cas::mav::services {
namespace {

using namespace std::chrono_literals;
using mavlink::common::FileTransferProtocol;
using mavlink::common::MavFtpErr;
using Opcode = mavlink::common::MavFtpOpcode;
using Bytes = std::vector<std::uint8_t>;

constexpr Source kSelf{255, 190};

Bytes some_bytes(std::size_t count) {
  std::mt19937 random(7);
  Bytes bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

/// A client on a virtual clock. Its requests wait in `asked_`.
class Ftp : public testing::Test {
 protected:
  FtpExchange::Done done() {
    return [this](const Outcome& outcome, const FtpResult& result) {
      ++ended_;
      outcome_ = outcome;
      result_ = result;
    };
  }
  void deliver(const FtpPayload& answer, Source to = kSelf) {
    const auto packet = encode_packet_(addressed(ftp_message(answer), to));
    exchange_.on_packet(view_packet(packet), kSelf, now_);
  }
  void pass(Duration time) {
    now_ += time;
    exchange_.tick(now_);
  }
  void time_out() {
    for (int i = 0; i < 100 && exchange_.busy(); ++i) pass(300ms);
  }
  /// An answer to the newest request.
  FtpPayload answer(Opcode opcode = Opcode::kAck) const {
    const FtpPayload& request = asked_.back();
    FtpPayload reply{.seq = static_cast<std::uint16_t>(request.seq + 1),
                     .session = request.session,
                     .opcode = opcode,
                     .req_opcode = request.opcode,
                     .offset = request.offset};
    return reply;
  }
  void acknowledge() { deliver(answer()); }
  void acknowledge(std::uint32_t number, std::uint8_t session = 3) {
    FtpPayload reply = answer();
    reply.session = session;
    reply.set_number(number);
    deliver(reply);
  }
  /// A download of "a", a file of so many bytes.
  void begin(std::uint32_t bytes) {
    exchange_.download("a", now_, done());
    acknowledge(bytes);
  }
  void refuse(MavFtpErr code, std::uint8_t error_number = 0) {
    FtpPayload reply = answer(Opcode::kNak);
    reply.set_bytes(std::array{static_cast<std::uint8_t>(code), error_number});
    if (code != MavFtpErr::kFailerrno) reply.size = 1;
    deliver(reply);
  }
  /// A packet of the burst that was asked for last.
  FtpPayload piece(std::uint16_t number, std::uint32_t offset, std::size_t size = 239) const {
    FtpPayload reply = answer();
    reply.seq = static_cast<std::uint16_t>(reply.seq + number);
    reply.offset = offset;
    reply.set_bytes(std::span(file_).subspan(offset, size));
    return reply;
  }
  void acknowledge_text(const std::string& text) {
    FtpPayload reply = answer();
    reply.set_text(text);
    deliver(reply);
  }
  Opcode asked() const { return asked_.back().opcode; }

  Time now_{1s};
  Encoder encode_packet_{{.system = 1, .component = 1}};
  Bytes file_ = some_bytes(1000);
  int ended_ = 0;
  std::optional<Outcome> outcome_;
  FtpResult result_;
  std::vector<FtpPayload> asked_;
  FtpExchange exchange_{[this](const auto& message) { asked_.push_back(ftp_payload(message)); }};
};

TEST_F(Ftp, AsksOnlyForTheGapsOfABurst) {
  exchange_.download("/log/a.ulg", now_, done());
  EXPECT_EQ(asked(), Opcode::kOpenfilero);
  EXPECT_EQ(asked_.back().text(), "/log/a.ulg");
  acknowledge(1000);
  EXPECT_EQ(asked(), Opcode::kBurstreadfile);
  EXPECT_EQ(asked_.back().session, 3);
  FtpPayload last = piece(4, 956, 44);
  last.burst_complete = true;
  deliver(piece(2, 478));  // out of order; the one at 239 is lost
  deliver(piece(0, 0));
  deliver(piece(0, 0));
  deliver(piece(3, 717));
  deliver(last);
  ASSERT_EQ(asked(), Opcode::kReadfile);
  EXPECT_EQ(asked_.back().offset, 239U);
  EXPECT_EQ(asked_.back().size, 239);
  deliver(piece(0, 239));
  EXPECT_EQ(asked(), Opcode::kTerminatesession);
  EXPECT_EQ(asked_.back().session, 3);
  acknowledge();
  EXPECT_EQ(asked(), Opcode::kCalcfilecrc);
  EXPECT_FALSE(outcome_);
  acknowledge(ftp_crc32(file_));
  ASSERT_TRUE(outcome_);
  EXPECT_TRUE(outcome_->ok());
  EXPECT_TRUE(result_.checked);
  EXPECT_EQ(result_.bytes, file_);
  EXPECT_FALSE(exchange_.deadline());
}

TEST_F(Ftp, BurstThatStopsIsAskedForFromWhereItStopped) {
  begin(1000);
  deliver(piece(0, 0));
  deliver(piece(1, 239));
  EXPECT_EQ(exchange_.deadline(), now_ + 300ms);
  pass(300ms);
  EXPECT_EQ(asked(), Opcode::kBurstreadfile);
  EXPECT_EQ(asked_.back().offset, 478U);
}

TEST_F(Ftp, BurstLongerThanHalfOfTheNumbersIsTakenWhole) {
  file_ = some_bytes(40'000);
  begin(40'000);
  const FtpPayload first = piece(0, 0, 1);
  for (std::uint16_t i = 0; i < 40'000; ++i) {
    FtpPayload next = first;
    next.seq = static_cast<std::uint16_t>(first.seq + i);
    next.offset = i;
    next.data[0] = file_[i];
    deliver(next);
  }
  EXPECT_EQ(exchange_.oddities().stray, 0U);
  EXPECT_EQ(asked(), Opcode::kTerminatesession);
  acknowledge();
  acknowledge(ftp_crc32(file_));
  ASSERT_TRUE(outcome_ && outcome_->ok());
  EXPECT_TRUE(result_.bytes == file_);
}

TEST_F(Ftp, FirstNumberIsTheCallers) {
  FtpExchange other([this](const auto& message) { asked_.push_back(ftp_payload(message)); }, {},
                    7000);
  exchange_.list("/", now_, done());
  other.list("/", now_, done());
  EXPECT_EQ(asked_[1].seq - asked_[0].seq, 7000);
}

TEST_F(Ftp, ServerHasLongerForAChecksum) {
  begin(100);
  deliver(piece(0, 0, 100));
  acknowledge();
  ASSERT_EQ(asked(), Opcode::kCalcfilecrc);
  EXPECT_EQ(exchange_.deadline(), now_ + 2s);
}

TEST_F(Ftp, PiecesOfAnEarlierTransferAreNotTaken) {
  begin(1000);
  const FtpPayload late = piece(40, 0);
  deliver(piece(0, 0));
  exchange_.give_up(failure(OutcomeKind::kTimeout, "stopped"));
  EXPECT_EQ(asked(), Opcode::kTerminatesession);
  exchange_.download("b", now_, done());
  acknowledge(1000);
  deliver(late);
  EXPECT_EQ(exchange_.oddities().stray, 1U);
  exchange_.give_up(failure(OutcomeKind::kTimeout, "stopped"));
  EXPECT_TRUE(result_.bytes.empty());
}

TEST_F(Ftp, ServerWithoutBurstsAndChecksumsIsReadPieceByPiece) {
  begin(300);
  refuse(MavFtpErr::kUnknowncommand);
  EXPECT_EQ(asked(), Opcode::kReadfile);
  deliver(piece(0, 0));
  EXPECT_EQ(asked_.back().offset, 239U);
  EXPECT_EQ(asked_.back().size, 61);
  deliver(piece(0, 239, 61));
  refuse(MavFtpErr::kInvalidsession);  // of TerminateSession
  refuse(MavFtpErr::kUnknowncommand);  // of CalcFileCRC32
  ASSERT_TRUE(outcome_ && outcome_->ok());
  EXPECT_FALSE(result_.checked);
  EXPECT_EQ(result_.bytes, Bytes(file_.begin(), file_.begin() + 300));
}

TEST_F(Ftp, FileIsOpenedAgainWhenTheServerHasRestarted) {
  begin(1000);
  deliver(piece(0, 0));
  pass(300ms);
  refuse(MavFtpErr::kInvalidsession);
  ASSERT_EQ(asked(), Opcode::kOpenfilero);
  acknowledge(1000, 5);
  EXPECT_EQ(asked(), Opcode::kBurstreadfile);
  EXPECT_EQ(asked_.back().offset, 239U);
  EXPECT_EQ(asked_.back().session, 5);
  refuse(MavFtpErr::kInvalidsession);
  acknowledge(900, 6);
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->message,
            "reading 'a', 239 of 1000 bytes: the file has changed its length meanwhile");
}

TEST_F(Ftp, ServerThatRestartsForEverIsGivenUp) {
  exchange_.download("a", now_, done());
  for (int i = 0; i < 20 && !outcome_; ++i) {
    acknowledge(1000);
    refuse(MavFtpErr::kInvalidsession);
  }
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
  EXPECT_EQ(ended_, 1);
}

TEST_F(Ftp, FileThatChangedMeanwhileIsSaid) {
  begin(100);
  deliver(piece(0, 0, 100));
  acknowledge();
  acknowledge(ftp_crc32(file_));
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->message,
            "reading 'a', 100 of 100 bytes: the file at the vehicle has another checksum: it has "
            "changed meanwhile, or was damaged");
  EXPECT_FALSE(result_.checked);
  EXPECT_EQ(result_.bytes.size(), 100U);
}

TEST_F(Ftp, RequestsComeAgainWithTheirNumberThenEnd) {
  exchange_.remove("a", now_, done());
  time_out();
  ASSERT_EQ(asked_.size(), 10U);
  for (const FtpPayload& request : asked_) EXPECT_EQ(request, asked_[0]);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
  EXPECT_EQ(outcome_->message, "removing 'a', then nothing more came");
}

TEST_F(Ftp, BurstThatGetsNoAnswerComesAgainAsANewOne) {
  begin(1000);
  const std::uint16_t first = asked_.back().seq;
  pass(300ms);
  EXPECT_EQ(asked(), Opcode::kBurstreadfile);
  EXPECT_NE(asked_.back().seq, first);
  time_out();
  EXPECT_EQ(outcome_->message, "reading 'a', 0 of 1000 bytes, then nothing more came");
  EXPECT_EQ(asked(), Opcode::kTerminatesession);
}

TEST_F(Ftp, RequestBehindABurstHasANumberThatNoLostPacketTook) {
  begin(1000);
  const std::uint16_t burst = asked_.back().seq;
  deliver(piece(0, 0));  // the other packets are lost
  pass(300ms);
  ASSERT_EQ(asked(), Opcode::kBurstreadfile);
  EXPECT_GE(static_cast<std::uint16_t>(asked_.back().seq - burst), 256);
  FtpPayload end = piece(0, 239);
  end.burst_complete = true;
  deliver(end);
  const std::uint16_t next = asked_.back().seq;
  EXPECT_GE(static_cast<std::uint16_t>(next - end.seq), 256);
}

TEST_F(Ftp, ServerThatHasAnsweredOnceIsGivenTenSeconds) {
  file_ = some_bytes(1000);
  begin(1000);
  FtpPayload last = piece(4, 956, 44);
  last.burst_complete = true;
  deliver(piece(0, 0));
  deliver(last);
  ASSERT_EQ(asked(), Opcode::kReadfile);
  for (int i = 0; i < 30; ++i) pass(300ms);
  EXPECT_TRUE(exchange_.busy()) << "9 s";
  deliver(piece(0, 239));
  for (int i = 0; i < 30; ++i) pass(300ms);
  EXPECT_TRUE(exchange_.busy());
  for (int i = 0; i < 5; ++i) pass(300ms);
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->kind, OutcomeKind::kTimeout);
}

TEST_F(Ftp, TransferThatTricklesIsGivenUp) {
  begin(200'000);
  for (std::uint16_t i = 0; i < 20'000 && !outcome_; ++i) {
    FtpPayload reply = answer();
    reply.seq = static_cast<std::uint16_t>(reply.seq + i);
    reply.offset = i;
    reply.size = 1;
    deliver(reply);
    pass(290ms);
  }
  ASSERT_TRUE(outcome_);
  EXPECT_NE(outcome_->message.find("; the rest would take too long"), std::string::npos);
}

TEST_F(Ftp, ListGoesOnUntilItsEnd) {
  exchange_.list("/", now_, done());
  acknowledge_text(std::string("Fa.txt\t12\0Dlog\0S\0", 17));
  EXPECT_EQ(asked_.back().offset, 3U);
  acknowledge_text(std::string("F../../etc/passwd\t5\0D..\0F\t1\0Fb\t7", 33));
  EXPECT_EQ(asked_.back().offset, 7U);
  refuse(MavFtpErr::kEof);
  ASSERT_TRUE(outcome_ && outcome_->ok());
  const std::vector<FtpEntry> expected{{false, "a.txt", 12}, {true, "log", 0}, {false, "b", 7}};
  EXPECT_EQ(result_.entries, expected);
}

TEST_F(Ftp, FolderWithoutAnEndIsGivenUp) {
  exchange_.list("/", now_, done());
  for (int i = 0; i < 100'000 && !outcome_; ++i) {
    acknowledge_text(std::string("Fa\t1\0Fa\t1\0", 10));
  }
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->message, "listing '/': the folder has more than 8192 entries");
}

TEST_F(Ftp, HostileAnswersAreCountedAndCostNothing) {
  exchange_.download("a", now_, done());
  FtpPayload reply = answer();
  reply.set_number(1000);
  reply.seq = static_cast<std::uint16_t>(reply.seq + 1);
  deliver(reply);  // another number
  deliver(answer(), {7, 1});
  reply = answer();
  reply.req_opcode = Opcode::kReadfile;
  deliver(reply);  // another operation
  EXPECT_EQ(exchange_.oddities().stray, 2U);
  reply = answer();
  reply.size = 255;
  deliver(reply);
  EXPECT_EQ(exchange_.oddities().malformed, 1U);
  EXPECT_EQ(asked(), Opcode::kOpenfilero);
  acknowledge(1000);
  reply = piece(0, 0);
  reply.offset = 1000;
  deliver(reply);
  reply.offset = 0xFFFFFFFF;
  deliver(reply);
  EXPECT_EQ(exchange_.oddities().outside, 2U);
  reply.session = 4;
  deliver(reply);
  EXPECT_EQ(exchange_.oddities().stray, 3U);
  // A piece beyond the end is cut.
  for (std::uint16_t i = 0; i < 4; ++i) deliver(piece(i, 239U * i));
  reply = piece(4, 956, 44);
  reply.size = 239;
  deliver(reply);
  acknowledge();
  acknowledge(ftp_crc32(file_));
  ASSERT_TRUE(outcome_ && outcome_->ok());
  EXPECT_EQ(result_.bytes, file_);
  deliver(reply);  // nothing is under way
  EXPECT_EQ(ended_, 1);
}

TEST_F(Ftp, BurstsWithoutBytesEndInAReadThatSaysWhy) {
  begin(1000);
  refuse(MavFtpErr::kEof);
  EXPECT_EQ(asked(), Opcode::kReadfile);
  refuse(MavFtpErr::kEof);
  EXPECT_EQ(outcome_->message,
            "reading 'a', 0 of 1000 bytes: the file has become shorter meanwhile");
}

TEST_F(Ftp, FilesAndMemoryAreBounded) {
  begin(0xFFFFFFFF);
  EXPECT_EQ(outcome_->message, "reading 'a': the file has 4294967295 bytes, more than may be read");
  EXPECT_EQ(asked(), Opcode::kTerminatesession);
  exchange_.download("a", now_, done());
  acknowledge();  // no length
  EXPECT_EQ(outcome_->message, "reading 'a': the vehicle does not tell the file's length");
}

TEST_F(Ftp, WhatCannotBeAskedEndsAtOnce) {
  exchange_.download("", now_, done());
  EXPECT_EQ(outcome_->kind, OutcomeKind::kInvalid);
  exchange_.download(std::string(240, 'a'), now_, done());
  EXPECT_EQ(outcome_->message, "a path has 1 to 239 bytes");
  exchange_.download("a", now_, done());
  exchange_.list("/", now_, done());
  EXPECT_EQ(outcome_->message, "another file transfer is under way");
  EXPECT_EQ(asked_.size(), 1U);
}

struct Refusal {
  MavFtpErr code;
  const char* words;
};

TEST_F(Ftp, EachRefusalHasWords) {
  for (const auto& [code, words] :
       {Refusal{MavFtpErr::kFail, "it failed, without a reason (Fail)"},
        Refusal{MavFtpErr::kFailerrno,
                "its file system failed with errno 28 (FailErrno), which is "
                "'No space left on device' here"},
        Refusal{MavFtpErr::kInvaliddatasize, "the request has a wrong size (InvalidDataSize)"},
        Refusal{MavFtpErr::kInvalidsession, "the file is not open there (InvalidSession)"},
        Refusal{MavFtpErr::kNosessionsavailable,
                "too many files are open there (NoSessionsAvailable)"},
        Refusal{MavFtpErr::kEof, "there is nothing behind the end (EOF)"},
        Refusal{MavFtpErr::kUnknowncommand, "it has no such operation (UnknownCommand)"},
        Refusal{MavFtpErr::kFileexists, "the name is taken (FileExists)"},
        Refusal{MavFtpErr::kFileprotected, "it must not be changed (FileProtected)"},
        Refusal{MavFtpErr::kFilenotfound, "there is no such file or folder (FileNotFound)"},
        Refusal{static_cast<MavFtpErr>(77), "error 77"}}) {
    exchange_.upload("a", {}, now_, done());
    refuse(code, 28);
    EXPECT_EQ(outcome_->kind, OutcomeKind::kRefused);
    EXPECT_EQ(outcome_->message, std::string("writing 'a': the vehicle says that ") + words);
  }
}

TEST_F(Ftp, WhateverIsAnsweredATransferEnds) {
  std::mt19937 random(5);
  const auto any = [&](std::uint32_t below) {
    return static_cast<std::uint32_t>(random()) % below;
  };
  constexpr std::array kOffsets{0U, 239U, 478U, 999U, 1000U, 0xFFFFFFFFU};
  for (int round = 0; round < 300; ++round) {
    const int before = ended_;
    if (round % 3 == 0) exchange_.list("a", now_, done());
    if (round % 3 == 1) exchange_.download("a", now_, done());
    if (round % 3 == 2) exchange_.upload("a", some_bytes(500), now_, done());
    for (int i = 0; i < 200 && exchange_.busy(); ++i) {
      FtpPayload reply = answer(any(4) == 0 ? Opcode::kNak : Opcode::kAck);
      reply.seq = static_cast<std::uint16_t>(reply.seq + any(3) * any(3));
      reply.offset = any(2) == 0 ? reply.offset : kOffsets[any(kOffsets.size())];
      for (auto& byte : reply.data) byte = static_cast<std::uint8_t>(any(4) == 0 ? any(256) : 0);
      reply.data[0] = static_cast<std::uint8_t>(any(12));
      reply.data[1] = 3;  // with data[0] a length of about 768 bytes
      reply.data[2] = reply.data[3] = 0;
      reply.size = static_cast<std::uint8_t>(any(256));
      reply.burst_complete = any(8) == 0;
      if (any(8) == 0) reply.session = static_cast<std::uint8_t>(any(3));
      deliver(reply);
      pass(10ms);
    }
    time_out();
    EXPECT_EQ(ended_, before + 1);
    EXPECT_LE(result_.bytes.size(), 1000U);
    EXPECT_LE(result_.checked, outcome_->ok());
  }
}

// Client and server, over a line that loses, doubles and swaps packets.

struct LineCase {
  const char* name;
  double loss;
  double twice;
  double swap;
};

class FtpLine : public testing::TestWithParam<LineCase> {
 protected:
  static constexpr FtpServerLimits kLimits{.bytes_per_s = 266'000};

  /// Puts a packet on the line, in either direction.
  void put(bool to_server, const FileTransferProtocol& message) {
    std::uniform_real_distribution<double> chance;
    if (chance(random_) < GetParam().loss) return;
    line_.push_back({to_server, message});
    if (chance(random_) < GetParam().twice) line_.push_back({to_server, message});
    if (line_.size() > 1 && chance(random_) < GetParam().swap) {
      std::swap(line_.back(), line_[line_.size() - 2]);
    }
  }
  void run(const std::function<void()>& meanwhile = [] {}) {
    for (int i = 0; i < 100'000 && exchange_.busy(); ++i) {
      now_ += 5ms;
      const auto arrived = std::exchange(line_, {});
      for (const auto& [to_server, message] : arrived) {
        if (to_server) {
          server_->on_request(message, kSelf, now_);
        } else {
          exchange_.on_packet(view_packet(encode_packet_(message)), kSelf, now_);
        }
      }
      server_->update(now_);
      exchange_.tick(now_);
      meanwhile();
    }
  }
  void restart_server() { server_.emplace(store_, to_client_, kLimits); }
  FtpExchange::Done done() {
    return [this](const Outcome& outcome, const FtpResult& result) {
      outcome_ = outcome;
      result_ = result;
    };
  }

  std::mt19937 random_{11};
  Time now_{1s};
  Encoder encode_packet_{{.system = 1, .component = 1}};
  std::vector<std::pair<bool, FileTransferProtocol>> line_;
  MemoryFtpStore store_;
  FtpServer::Send to_client_ = [this](const auto& message) {
    put(false, message);
    return std::size_t{266};
  };
  std::optional<FtpServer> server_{std::in_place, store_, to_client_, kLimits};
  FtpExchange exchange_{[this](const auto& message) { put(true, message); }};
  Outcome outcome_;
  FtpResult result_;
};

TEST_P(FtpLine, BringsFilesDownAndUp) {
  store_.files["log/a.ulg"] = some_bytes(150'000);
  exchange_.download("/log/a.ulg", now_, done());
  run();
  EXPECT_EQ(outcome_.message, "");
  EXPECT_TRUE(result_.checked);
  EXPECT_TRUE(result_.bytes == store_.files["log/a.ulg"]);
  exchange_.upload("log/b.ulg", some_bytes(5000), now_, done());
  run();
  EXPECT_EQ(outcome_.message, "");
  EXPECT_TRUE(result_.checked);
  EXPECT_TRUE(store_.files["log/b.ulg"] == some_bytes(5000));
  exchange_.download("log/b.ulg", now_, done());  // the sessions before are closed
  run();
  EXPECT_TRUE(outcome_.ok() && result_.bytes == some_bytes(5000));
}

TEST_P(FtpLine, OutlivesARestartOfTheServer) {
  store_.files["a"] = some_bytes(150'000);
  exchange_.download("a", now_, done());
  int steps = 0;
  run([&] {
    if (++steps == 100) restart_server();
  });
  EXPECT_EQ(outcome_.message, "");
  EXPECT_TRUE(result_.bytes == store_.files["a"]);
}

TEST_P(FtpLine, ListsLongFolders) {
  for (int i = 0; i < 100; ++i) store_.files["log/2026-11-22/" + std::to_string(i) + ".ulg"];
  exchange_.list("log/2026-11-22", now_, done());
  run();
  EXPECT_TRUE(outcome_.ok()) << outcome_.message;
  EXPECT_EQ(result_.entries.size(), 100U);
}

INSTANTIATE_TEST_SUITE_P(Lines, FtpLine,
                         testing::Values(LineCase{"Good", 0, 0, 0}, LineCase{"Losing", 0.15, 0, 0},
                                         LineCase{"Doubling", 0, 0.3, 0},
                                         LineCase{"Swapping", 0, 0, 0.3},
                                         LineCase{"Bad", 0.1, 0.1, 0.1}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::mav::services

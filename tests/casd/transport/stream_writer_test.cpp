// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/stream_writer.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::casd::test {
namespace {

using cas::test::PacketStream;
using cas::test::PtyPair;
using cas::test::wait_until;

constexpr std::size_t kMostZeros = 5;  // of a nudge

class PtyWriterTest : public testing::Test {
 protected:
  void write(std::size_t size) {
    const auto content = bytes(size, 1);
    const PacketInfo any;
    const PacketRef packet{&any, content};
    writer.write({&packet, 1});
  }
  /// Reads all; it has arrived when the first byte has.
  std::size_t read() {
    std::size_t got = 0;
    EXPECT_TRUE(wait_until([&] { return (got = line.read(heard)) > 0; }));
    return got;
  }
  /// The kernel hands bytes on, and wakes writers, in its own time.
  bool moves() {
    return wait_until([&] { return writer.moved(); });
  }
  bool rests() {
    return wait_until([&] { return !writer.moved(); });
  }
  PtyPair line;
  PacketStream heard;
  StreamWriter writer{
      base::Descriptor(::open(line.slave().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)),
      StreamWriter::Kind::kPseudoTerminal};
};

TEST_F(PtyWriterTest, TellsWhetherTheReaderReads) {
  write(77);
  EXPECT_TRUE(writer.moved()) << "it is believed to read while there is room";
  read();
  EXPECT_TRUE(moves());
  // A write that took its time is in doubt; sooner or later one is not.
  EXPECT_TRUE(wait_until([&] {
    write(77);
    return !writer.moved();
  })) << "a write of our own is no sign of a reader";
  read();
  EXPECT_TRUE(moves());
  EXPECT_TRUE(rests()) << "once";
}

TEST_F(PtyWriterTest, ALookThatBeginsForgetsWhatWasReadBefore) {
  write(77);
  read();
  ASSERT_TRUE(moves());
  writer.watch(false);
  write(77);
  read();
  // The kernel may wake writers after the look has begun: in the end it has not.
  EXPECT_TRUE(wait_until([&] {
    writer.watch(true);
    return !writer.moved();
  }));
  write(77);
  read();
  EXPECT_TRUE(moves());
}

TEST_F(PtyWriterTest, TellsAReaderThatNeverReadsAllByTheRoomThatItMakes) {
  write(77);
  read();
  ASSERT_TRUE(moves());
  const auto fill = [&] {
    for (int i = 0; i < 1000; ++i) write(77);
  };
  pollfd room{writer.descriptor(), POLLOUT, 0};
  EXPECT_TRUE(wait_until([&] {
    fill();
    return ::poll(&room, 1, 0) == 0;
  })) << "the kernel makes room of its own while it hands bytes on";
  EXPECT_TRUE(rests());
  line.read(heard, 4096);  // most of it stays
  ASSERT_EQ(::poll(&room, 1, 20'000), 1) << "the kernel takes its time";
  fill();
  EXPECT_TRUE(writer.moved());
}

TEST_F(PtyWriterTest, TellsAReaderThatNeverReadAtAllByTheRoomThatItDoesNotMake) {
  EXPECT_TRUE(wait_until([&] {
    for (int i = 0; i < 1000; ++i) write(77);
    return !writer.moved();
  })) << "the kernel moves bytes on in its own time";
  EXPECT_FALSE(writer.flush()) << "room made so would look like a reader";
  EXPECT_TRUE(wait_until([&] {
    line.read(heard);
    return writer.moved();
  }));
}

TEST_F(PtyWriterTest, NudgeIsAZeroThatNoPacketBeginsWith) {
  write(77);
  read();
  heard = {};
  writer.nudge();
  const std::size_t zeros = read();
  EXPECT_LE(zeros, kMostZeros);
  EXPECT_EQ(heard.garbage(), zeros);
  EXPECT_TRUE(moves());
}

TEST_F(PtyWriterTest, FlushTakesBackAllButWhatTheReadersTerminalHolds) {
  constexpr std::size_t kTerminal = 4096;  // N_TTY_BUF_SIZE of Linux
  write(77);
  read();
  ASSERT_TRUE(moves());
  for (int i = 0; i < 1000; ++i) write(77);
  EXPECT_TRUE(writer.flush());
  std::size_t left = 0;
  ASSERT_TRUE(wait_until([&] {
    const std::size_t got = line.read(heard);
    left += got;
    return left > 0 && got == 0;
  }));
  EXPECT_LE(left, kTerminal + kMostZeros);
}

}  // namespace
}  // namespace cas::casd::test

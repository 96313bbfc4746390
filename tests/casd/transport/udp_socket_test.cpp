// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_socket.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <span>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/transport/socket_address.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::casd::test {
namespace {

using cas::test::wait_until;

TEST(DatagramReader, TellsWhatTheKernelDropped) {
  const SocketAddress any = AddressLookup("127.0.0.1:0").address();
  const base::Descriptor in(open_udp_socket(any.family(), ""));
  ASSERT_EQ(::bind(in.get(), any.get(), any.size), 0);
  const int small = 8192;
  ASSERT_EQ(::setsockopt(in.get(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small), 0);
  const base::Descriptor out(open_udp_socket(any.family(), ""));
  const SocketAddress to = local_address(in.get());
  constexpr unsigned kSent = 1000;
  const std::array<char, 60> packet{};
  const auto send = [&] {
    ASSERT_EQ(::sendto(out.get(), packet.data(), packet.size(), 0, to.get(), to.size), 60);
  };
  for (unsigned i = 0; i < kSent; ++i) send();

  DatagramReader reader;
  unsigned received = 0;
  while (const int count = reader.read(in.get(), base::steady_now()))
    received += static_cast<unsigned>(count);
  send();  // the count comes with the next datagram
  received += static_cast<unsigned>(reader.read(in.get(), base::steady_now()));
  EXPECT_LT(received, kSent);
  EXPECT_EQ(received + reader.kernel_drops(), kSent + 1);
}

TEST(DatagramReader, TellsHowLongADatagramLayInTheSocket) {
  const SocketAddress any = AddressLookup("127.0.0.1:0").address();
  const base::Descriptor in(open_udp_socket(any.family(), ""));
  ASSERT_EQ(::bind(in.get(), any.get(), any.size), 0);
  const base::Descriptor out(open_udp_socket(any.family(), ""));
  const SocketAddress to = local_address(in.get());
  base::RunTime begin = base::steady_now();
  const auto wait_for = [&](base::Duration since_begin) {
    ASSERT_TRUE(wait_until([&] { return base::steady_now() - begin > since_begin; }));
  };
  const char packet = 1;
  // The kernel begins to stamp in its own time after the first socket of the machine asks for it.
  ASSERT_TRUE(wait_until([&] {
    begin = base::steady_now();
    ::sendto(out.get(), &packet, 1, 0, to.get(), to.size);
    wait_for(2 * DatagramReader::kPrompt);
    DatagramReader stamped;
    return stamped.read(in.get(), base::steady_now()) == 1 && stamped.waited(0) > base::Duration{};
  }));
  begin = base::steady_now();
  ASSERT_EQ(::sendto(out.get(), &packet, 1, 0, to.get(), to.size), 1);
  wait_for(std::chrono::milliseconds(50));
  ASSERT_EQ(::sendto(out.get(), &packet, 1, 0, to.get(), to.size), 1);
  DatagramReader reader;
  ASSERT_EQ(reader.read(in.get(), base::steady_now()), 2);
  const base::Duration most = base::steady_now() - begin;
  EXPECT_GE(reader.waited(0), std::chrono::milliseconds(40));
  EXPECT_LE(reader.waited(0), most + std::chrono::milliseconds(10));
  EXPECT_LE(reader.waited(1), reader.waited(0) - std::chrono::milliseconds(40));
}

/// A reader and a socket that sends to it.
class Datagrams : public testing::Test {
 protected:
  Datagrams() { EXPECT_EQ(::bind(in_.get(), any_.get(), any_.size), 0); }
  void send(int count) {
    const char packet = 1;
    const SocketAddress to = local_address(in_.get());
    for (int i = 0; i < count; ++i) ::sendto(out_.get(), &packet, 1, 0, to.get(), to.size);
  }
  int read(base::RunTime now) { return reader_.read(in_.get(), now); }

  const SocketAddress any_ = AddressLookup("127.0.0.1:0").address();
  const base::Descriptor in_{open_udp_socket(AF_INET, "")};
  const base::Descriptor out_{open_udp_socket(AF_INET, "")};
  DatagramReader reader_;
  base::RunTime now_ = base::steady_now();
};

TEST_F(Datagrams, ThatComeOneByOneAreReadOneByOne) {
  // On a busy machine one may wait in the socket; then both are read together.
  EXPECT_TRUE(wait_until([&] {
    while (read(base::steady_now()) > 0) continue;
    send(1);
    EXPECT_EQ(read(base::steady_now()), 1);
    const base::RunTime before = base::steady_now();
    EXPECT_TRUE(wait_until([&] { return base::steady_now() - before > DatagramReader::kSoon; }));
    send(2);
    return read(base::steady_now()) == 1 && read(base::steady_now()) == 1;
  }));
  EXPECT_EQ(read(base::steady_now()), 0);
}

TEST_F(Datagrams, ThatComeInAFloodAreReadTogether) {
  send(40);
  EXPECT_EQ(read(now_), 32);
  EXPECT_EQ(read(now_), 8);
  EXPECT_EQ(read(now_), 0);
}

TEST_F(Datagrams, ThatHaveWaitedAreReadTogether) {
  constexpr base::Duration kLong = std::chrono::milliseconds(20);
  // The kernel begins to stamp in its own time after the first socket of the machine asks for it.
  ASSERT_TRUE(wait_until([&] {
    send(1);
    const base::RunTime sent = base::steady_now();
    EXPECT_TRUE(wait_until([&] { return base::steady_now() - sent > kLong; }));
    return read(base::steady_now()) == 1 && reader_.waited(0) > base::Duration{};
  }));
  const base::RunTime begin = base::steady_now();
  send(10);
  const base::RunTime sent = base::steady_now();
  ASSERT_TRUE(wait_until([&] { return base::steady_now() - sent > kLong; }));
  EXPECT_EQ(read(base::steady_now()), 10);
  // The estimate of the wall clock may be off by what it took to read both clocks.
  constexpr base::Duration kClocks = std::chrono::milliseconds(10);
  EXPECT_GE(reader_.waited(0), kLong - kClocks);
  EXPECT_LE(reader_.waited(0), base::steady_now() - begin + kClocks);
}

TEST_F(Datagrams, ThatAreLargeAreReadWholeAndTheFirstCutIsCounted) {
  const std::vector<char> large(65507, 'x');
  const SocketAddress to = local_address(in_.get());
  const auto send_large = [&] {
    ASSERT_EQ(::sendto(out_.get(), large.data(), large.size(), 0, to.get(), to.size), 65507);
  };
  send_large();
  ASSERT_EQ(read(now_), 1);  // alone: there is room for any
  EXPECT_EQ(reader_.datagram(0).size(), large.size());
  send_large();
  send_large();
  ASSERT_EQ(read(now_), 2);
  EXPECT_EQ(reader_.datagram(1).size(), large.size());
  EXPECT_EQ(reader_.take_cut_bytes(), 0U);
}

TEST_F(Datagrams, ThatFindNoRoomAreCutAndCounted) {
  send(1);
  ASSERT_EQ(read(now_), 1);
  send(1);
  const std::vector<char> large(DatagramReader::kUsual + 100, 'x');
  const SocketAddress to = local_address(in_.get());
  ::sendto(out_.get(), large.data(), large.size(), 0, to.get(), to.size);
  ASSERT_EQ(read(now_), 2);
  EXPECT_EQ(reader_.datagram(1).size(), DatagramReader::kUsual);
  EXPECT_EQ(reader_.take_cut_bytes(), 100U);
  EXPECT_EQ(reader_.take_cut_bytes(), 0U);
}

TEST(DatagramSender, NamesThePacketsThatTheNetworkRefuses) {
  const base::Descriptor socket(open_udp_socket(AF_INET, ""));  // may not broadcast
  const SocketAddress everybody = AddressLookup("255.255.255.255:14550").address();
  const PacketInfo info;
  const std::vector<std::uint8_t> bytes(30);
  const auto of_size = [&](std::size_t size) {
    return PacketRef{&info, std::span(bytes).first(size)};
  };
  const std::array packets{of_size(20), of_size(20), of_size(30), of_size(10)};  // one run of two
  DatagramSender sender;
  const auto result = sender.send(socket.get(), packets, everybody.get(), everybody.size);
  EXPECT_EQ(result.packets, 4U);
  EXPECT_EQ(result.error, 0);
  EXPECT_EQ(std::vector(result.refused.begin(), result.refused.end()),
            (std::vector<std::size_t>{0, 1, 2, 3}));
  EXPECT_EQ(result.refusal, EACCES);
}

}  // namespace
}  // namespace cas::casd::test

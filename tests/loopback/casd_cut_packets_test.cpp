// SPDX-License-Identifier: BSD-3-Clause
// Packets that bridges cut, and halves whose rest never comes.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/link/held_packets.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/tcp_peer.hpp"

namespace cas::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kPackets = 30;
constexpr std::size_t kHeaderBytes = 10;

/// A serial line of these many packets.
Bytes line_of(mav::Source source, std::uint64_t packets) {
  mav::Encoder sender(source);
  Bytes line;
  for (std::uint64_t i = 1; i <= packets; ++i) {
    const auto packet = sender(hil_controls(i));
    line.insert(line.end(), packet.begin(), packet.end());
  }
  return line;
}

std::span<const std::uint8_t> piece(const Bytes& line, std::size_t at, std::size_t size) {
  return std::span(line).subspan(at, std::min(size, line.size() - at));
}

const std::string kServer =
    "schema: 1\nlinks:\n  - {name: sim, type: udp, local: \"127.0.0.1:0\", remote: \"$SIM\",\n"
    "     queue: {hil_max_age_ms: 60000}}\n"
    "  - {name: in, type: udp_server, local: \"127.0.0.1:0\"}\n"
    "routes:\n  - {from: in, to: sim}\n";

class CutPackets : public testing::Test {
 protected:
  void start(const std::string& yaml = kServer) {
    fixture_.start(yaml);
    one_.set_remote(fixture_.port("in"));
    two_.set_remote(fixture_.port("in"));
  }
  std::size_t arrived() const { return fixture_.at_sim.count(kHilControls); }
  bool arrive(std::size_t packets) {
    return fixture_.collect_until([&] { return arrived() == packets; });
  }

  CasdFixture fixture_;
  UdpPeer one_;
  UdpPeer two_;
};

class CutAnywhere : public CutPackets, public testing::WithParamInterface<std::size_t> {};

TEST_P(CutAnywhere, AllPacketsOfABridgeArrive) {
  start();
  const Bytes line = line_of({1, 1}, kPackets);
  for (std::size_t at = 0; at < line.size(); at += GetParam()) {
    one_.send(piece(line, at, GetParam()));
  }
  ASSERT_TRUE(arrive(kPackets)) << arrived();
  EXPECT_EQ(fixture_.status("in").peers, 1U);
  EXPECT_EQ(fixture_.status("in").rx.lost, 0U);
}

INSTANTIATE_TEST_SUITE_P(Sizes, CutAnywhere, testing::Values(7, 17, 64, 100, 300),
                         [](const auto& test) { return "Of" + std::to_string(test.param); });

TEST_F(CutPackets, AllOfAFixedPeerArrive) {
  fixture_.start(
      "schema: 1\nlinks:\n  - {name: sim, type: udp, local: \"127.0.0.1:0\", remote: \"$SIM\"}\n"
      "  - {name: in, type: udp, local: \"127.0.0.1:0\", remote: \"" +
      one_.endpoint() + "\"}\nroutes:\n  - {from: in, to: sim}\n");
  one_.set_remote(fixture_.port("in"));
  const Bytes line = line_of({1, 1}, kPackets);
  for (std::size_t at = 0; at < line.size(); at += 64) one_.send(piece(line, at, 64));
  EXPECT_TRUE(arrive(kPackets)) << arrived();
}

TEST_F(CutPackets, OfTwoBridgesNeverJoin) {
  start();
  const Bytes of_one = line_of({1, 1}, kPackets);
  const Bytes of_two = line_of({2, 1}, kPackets);
  for (std::size_t at = 0; at < of_one.size(); at += 64) {
    one_.send(piece(of_one, at, 64));
    two_.send(piece(of_two, at, 64));
  }
  ASSERT_TRUE(arrive(2 * kPackets)) << arrived();
  EXPECT_EQ(fixture_.status("in").rx.crc_errors, 0U);
}

// The half one asks for 255 bytes more. Were the packet held, it would come after kPacketPause, but
// on a busy machine so might a prompt one: the order tells them apart.
TEST_F(CutPackets, WholePacketsBehindAHalfOneLeaveAtOnce) {
  start();
  mav::Encoder sender({1, 1});
  const auto first = sender(hil_controls(1));
  one_.send(first);
  ASSERT_TRUE(arrive(1));
  Bytes half(first.begin(), first.begin() + kHeaderBytes + 2);
  half[1] = 255;
  one_.send(half);
  one_.send(sender(hil_controls(2)));
  two_.send(mav::Encoder({2, 1})(hil_controls(3)));
  ASSERT_TRUE(arrive(3));
  EXPECT_EQ(numbers(fixture_.at_sim, kHilControls), (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST_F(CutPackets, AWholePacketBetweenTwoHalvesWaitsForAPauseOnly) {
  start();
  const Bytes line = line_of({1, 1}, 2);
  Bytes bytes{line.begin(), line.begin() + kHeaderBytes};
  bytes[1] = 255;
  bytes.insert(bytes.end(), line.begin(), line.end() - 5);
  one_.send(bytes);
  EXPECT_TRUE(arrive(1));
  EXPECT_EQ(numbers(fixture_.at_sim, kHilControls).front(), 1U);
}

TEST_F(CutPackets, APayloadThatHoldsPacketsIsNoneOfThem) {
  start();
  const Bytes inside = line_of({9, 9}, 2);
  mavlink::common::FileTransferProtocol transfer;
  std::copy(inside.begin(), inside.end(), transfer.payload.begin() + 20);
  mav::Encoder sender({1, 1});
  const auto packet = sender(transfer);
  const Bytes whole(packet.begin(), packet.end());
  for (std::size_t at = 0; at < whole.size(); at += 100) one_.send(piece(whole, at, 100));
  one_.send(sender(hil_controls(1)));
  ASSERT_TRUE(arrive(1)) << arrived();
  EXPECT_EQ(fixture_.at_sim.count(mavlink::common::FileTransferProtocol::kId), 1U);
}

TEST_F(CutPackets, FloodsOfHalvesDisplaceNoHalfOfAPeer) {
  start();
  const Bytes line = line_of({1, 1}, 2);
  const std::size_t cut = line.size() / 2 + 9;
  one_.send(piece(line, 0, cut));
  for (int i = 0; i < 100; ++i) {
    UdpPeer stranger;
    stranger.set_remote(fixture_.port("in"));
    stranger.send(piece(line, 0, 20));
  }
  one_.send(piece(line, cut, line.size()));
  EXPECT_TRUE(arrive(2)) << arrived();
}

// The length byte of a HEARTBEAT was flipped: it asks for 240 bytes, and none but HEARTBEATs come.
class QuietStream : public CutPackets {
 protected:
  void expect_heartbeats_behind_a_false_one(
      const std::function<void(std::span<const std::uint8_t>)>& send) {
    mav::Encoder sender({1, 1});
    const auto first = sender(mavlink::common::Heartbeat{});
    Bytes flipped(first.begin(), first.end());
    flipped[1] = 0xF0;
    send(flipped);
    send(sender(mavlink::common::Heartbeat{}));
    EXPECT_TRUE(fixture_.collect_until([&] { return fixture_.at_sim.count(kHeartbeat) == 1; }));
  }
  static std::string with(const std::string& link) {
    return "schema: 1\nlinks:\n  - {name: sim, type: udp, local: \"127.0.0.1:0\", remote: "
           "\"$SIM\"}\n  - {name: in, " +
           link + "}\nroutes:\n  - {from: in, to: sim}\n";
  }
};

TEST_F(QuietStream, OfASerialLineLetsPacketsGoAfterAPause) {
  fixture_.start(with("type: serial, device: \"$FCU\""));
  expect_heartbeats_behind_a_false_one([&](auto bytes) { fixture_.fcu.write(bytes); });
}

TEST_F(QuietStream, OfATcpClientLetsPacketsGoAfterAPause) {
  fixture_.start(with("type: tcp_server, local: \"127.0.0.1:0\""));
  TcpPeer client(fixture_.port("in"));
  expect_heartbeats_behind_a_false_one([&](auto bytes) { client.send(bytes); });
}

TEST_F(QuietStream, OfATcpLinkLetsPacketsGoAfterAPause) {
  const TcpListener listener;
  fixture_.start(with("type: tcp, remote: \"" + listener.endpoint() + "\""));
  const int accepted = listener.accept();
  ASSERT_GE(accepted, 0);
  TcpPeer server(accepted, true);
  expect_heartbeats_behind_a_false_one([&](auto bytes) { server.send(bytes); });
}

TEST_F(QuietStream, KeepsAHalfPacketWhoseRestComesLate) {
  fixture_.start(with("type: tcp_server, local: \"127.0.0.1:0\""));
  TcpPeer client(fixture_.port("in"));
  const Bytes line = line_of({1, 1}, 1);
  client.send(piece(line, 0, 20));
  const base::RunTime sent = base::steady_now();
  ASSERT_TRUE(wait_until([&] { return base::steady_now() - sent > 2 * casd::kPacketPause; }));
  client.send(piece(line, 20, line.size()));
  EXPECT_TRUE(arrive(1));
}

class LargeDatagram : public CutPackets, public testing::WithParamInterface<std::size_t> {};

TEST_P(LargeDatagram, AllOfItsPacketsArrive) {
  start();
  const std::size_t one = line_of({1, 1}, 1).size();
  const std::size_t packets = GetParam() / one;
  one_.send(line_of({1, 1}, packets));
  EXPECT_TRUE(wait_until([&] { return fixture_.status("in").rx.packets == packets; }))
      << fixture_.status("in").rx.packets << " of " << packets;
}

INSTANTIATE_TEST_SUITE_P(Sizes, LargeDatagram, testing::Values(4090, 4200, 9000, 30000, 65500),
                         [](const auto& test) { return "Of" + std::to_string(test.param); });

}  // namespace
}  // namespace cas::test

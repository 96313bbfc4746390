// SPDX-License-Identifier: BSD-3-Clause
// Garbage and half packets on every kind of link: only whole packets go on, and the link stays up.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/tcp_peer.hpp"

namespace cas::test {
namespace {

constexpr std::uint64_t kSent = 200;

/// Packets in datagrams that are sent before the simulator must have them all. With the garbage
/// between them they fit into a socket's buffer, so that a late casd loses none.
constexpr std::uint64_t kAtOnce = 20;

/// Sends whole packets with random bytes and packets cut short between them, and checks the packets
/// at the simulator.
void expect_only_whole_packets(CasdFixture& fixture, bool stream,
                               const std::function<void(std::span<const std::uint8_t>)>& send) {
  std::mt19937 random(11);
  mav::Encoder sender({7, 1});
  const auto arrived = [&](std::uint64_t packets) {
    return fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == packets; });
  };
  for (std::uint64_t i = 1; i <= kSent; ++i) {
    const auto whole = sender(hil_controls(i));
    std::vector<std::uint8_t> bytes(whole.begin(), whole.end());
    std::vector<std::uint8_t> rubbish(random() % 40);
    for (std::uint8_t& byte : rubbish) byte = static_cast<std::uint8_t>(random());
    const std::size_t cut = 1 + random() % (bytes.size() - 1);
    if (random() % 2 == 0)
      rubbish.insert(rubbish.end(), bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(cut));
    if (!rubbish.empty()) send(rubbish);
    send(bytes);
    // A stream has a flow control of its own, and may end in a false start at any packet.
    if (!stream && i % kAtOnce == 0) {
      ASSERT_TRUE(arrived(i)) << i;
    }
  }
  // A stream may end in a false start: later bytes decide about it.
  const std::vector<std::uint8_t> silence(600, 0);
  if (stream) send(silence);
  ASSERT_TRUE(arrived(kSent));
  EXPECT_EQ(numbers(fixture.at_sim, kHilControls).back(), kSent);
  EXPECT_EQ(fixture.at_sim.garbage(), 0U);
  EXPECT_EQ(fixture.at_sim.packets().size(), kSent);
}

/// On a loaded machine nothing is dropped by age.
std::string with(const std::string& link) {
  return "schema: 1\nlinks:\n  - {name: sim, type: udp, local: \"127.0.0.1:0\", remote: \"$SIM\",\n"
         "     queue: {hil_max_age_ms: 60000}}\n"
         "  - {name: in, unknown_messages: drop, " +
         link +
         "}\n"
         "routes:\n  - {from: in, to: sim}\n";
}

TEST(CasdGarbage, OnASerialLine) {
  CasdFixture fixture(with("type: serial, device: \"$FCU\""));
  expect_only_whole_packets(fixture, true, [&](auto bytes) { fixture.fcu.write(bytes); });
}

TEST(CasdGarbage, OnAUdpLink) {
  CasdFixture fixture;
  UdpPeer peer;
  fixture.start(with("type: udp, local: \"127.0.0.1:0\", remote: \"" + peer.endpoint() + "\""));
  peer.set_remote(fixture.port("in"));
  expect_only_whole_packets(fixture, false, [&](auto bytes) { peer.send(bytes); });
}

TEST(CasdGarbage, OnAUdpServer) {
  CasdFixture fixture;
  UdpPeer peer;
  UdpPeer stranger;
  fixture.start(with("type: udp_server, local: \"127.0.0.1:0\""));
  peer.set_remote(fixture.port("in"));
  stranger.set_remote(fixture.port("in"));
  expect_only_whole_packets(fixture, false, [&](auto bytes) {
    stranger.send(std::vector<std::uint8_t>{0xFD, 1, 2});
    peer.send(bytes);
  });
  EXPECT_EQ(fixture.status("in").peers, 1U);  // a sender without a whole packet is no peer
}

TEST(CasdGarbage, OnATcpServer) {
  CasdFixture fixture(with("type: tcp_server, local: \"127.0.0.1:0\""));
  TcpPeer client(fixture.port("in"));
  ASSERT_TRUE(client.connected());
  client.send(std::vector<std::uint8_t>{0xFD});  // the client of a server begins with a packet
  expect_only_whole_packets(fixture, true, [&](auto bytes) { client.send(bytes); });
}

TEST(CasdGarbage, OnATcpLink) {
  const TcpListener listener;
  CasdFixture fixture(with("type: tcp, remote: \"" + listener.endpoint() + "\""));
  const int accepted = listener.accept();
  ASSERT_GE(accepted, 0);
  TcpPeer server(accepted, true);
  expect_only_whole_packets(fixture, true, [&](auto bytes) { server.send(bytes); });
}

}  // namespace
}  // namespace cas::test

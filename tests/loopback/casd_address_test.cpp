// SPDX-License-Identifier: BSD-3-Clause
// Every way to name an endpoint: IPv6, multicast, broadcast, a device, a host that is not there
// yet.
#include <gtest/gtest.h>

#include "tests/loopback/any_udp_peer.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/support/free_port.hpp"

namespace cas::test {
namespace {

const std::string kFcuOnly = "schema: 1\nlinks:\n  - {name: fcu, type: serial, device: \"$FCU\"}\n";

std::string udp(const std::string& local, const std::string& remote, const std::string& more = "") {
  return kFcuOnly + "  - {name: net, type: udp, local: \"" + local + "\", remote: \"" + remote +
         "\"" + more + "}\n";
}

/// Both ways between the controller's line and `peer`, which sends to `to`.
void expect_both_ways(CasdFixture& fixture, AnyUdpPeer& peer, const std::string& to) {
  PacketStream heard;
  mav::Encoder station({255, 190});
  std::uint64_t number = 0;
  ASSERT_TRUE(fixture.collect_until([&] {
    fixture.fcu.write(fixture.from_fcu(hil_controls(++number)));
    peer.send(to, station(mavlink::common::Heartbeat{}));
    peer.read(heard);
    return heard.count(kHilControls) >= 3 && fixture.at_fcu.count(kHeartbeat) >= 3;
  }));
  // Nothing comes back to where it came from.
  EXPECT_EQ(heard.count(kHeartbeat), 0U);
  EXPECT_EQ(fixture.at_fcu.count(kHilControls), 0U);
  EXPECT_EQ(heard.garbage(), 0U);
}

TEST(CasdAddress, SpeaksIpv6) {
  AnyUdpPeer peer("[::1]:0");
  if (!peer.bound()) GTEST_SKIP() << "no IPv6 on this machine";
  CasdFixture fixture(udp("[::1]:0", peer.endpoint()));
  ASSERT_EQ(fixture.status("net").state, casd::LinkState::kUp);
  expect_both_ways(fixture, peer, fixture.status("net").endpoint);
}

TEST(CasdAddress, Ipv6ServerKnowsItsPeers) {
  AnyUdpPeer peer("[::1]:0");
  if (!peer.bound()) GTEST_SKIP() << "no IPv6 on this machine";
  CasdFixture fixture(kFcuOnly + "  - {name: net, type: udp_server, local: \"[::1]:0\"}\n");
  expect_both_ways(fixture, peer, fixture.status("net").endpoint);
  EXPECT_EQ(fixture.status("net").peers, 1U);
}

TEST(CasdAddress, JoinsAMulticastGroupOnADeviceAndHearsNoEchoOfItself) {
  const std::string port = std::to_string(free_port());
  AnyUdpPeer peer("0.0.0.0:" + port);
  if (!peer.bound() || !peer.join("239.255.77.77")) GTEST_SKIP() << "no multicast on lo";
  // The peer sends from a port of its own: on one machine the shared port would be ours.
  AnyUdpPeer sender("127.0.0.1:0");
  ASSERT_TRUE(sender.join("239.255.77.77"));
  CasdFixture fixture(udp("0.0.0.0:" + port, "239.255.77.77:" + port, ", interface: lo"));
  ASSERT_EQ(fixture.status("net").state, casd::LinkState::kUp) << fixture.status("net").endpoint;

  PacketStream heard;
  mav::Encoder station({255, 190});
  ASSERT_TRUE(fixture.collect_until([&] {
    fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
    sender.send("239.255.77.77:" + port, station(mavlink::common::Heartbeat{}));
    peer.read(heard);
    return heard.count(kHilControls) >= 3 && fixture.at_fcu.count(kHeartbeat) >= 3;
  }));
  EXPECT_EQ(fixture.at_fcu.count(kHilControls), 0U);  // recognised our own packets
  EXPECT_EQ(fixture.status("net").rx.lost, 0U);
}

TEST(CasdAddress, SpeaksToABroadcastAddressAndHearsWhoAnswers) {
  AnyUdpPeer peer("0.0.0.0:0");
  const std::string port = peer.endpoint().substr(peer.endpoint().rfind(':'));
  CasdFixture fixture(udp("127.0.0.1:0", "127.255.255.255" + port));
  ASSERT_EQ(fixture.status("net").state, casd::LinkState::kUp) << fixture.status("net").endpoint;
  expect_both_ways(fixture, peer, fixture.status("net").endpoint);
}

TEST(CasdAddress, BindsToADeviceAndWaitsForOneThatIsNotThere) {
  CasdFixture fixture(udp("127.0.0.1:0", fixture.sim.endpoint(), ", interface: lo"));
  EXPECT_EQ(fixture.status("net").state, casd::LinkState::kUp) << fixture.status("net").endpoint;
  fixture.links().reload(fixture.parse(udp("127.0.0.1:0", "127.0.0.1:9", ", interface: nosuch0")));
  ASSERT_TRUE(wait_until([&] { return fixture.status("net").state == casd::LinkState::kDown; }));
  EXPECT_NE(fixture.status("net").endpoint.find("device"), std::string::npos)
      << fixture.status("net").endpoint;
}

TEST(CasdAddress, ReachesAStationBeforeItFirstSpeaksAndFromItsFirstMoment) {
  const std::uint16_t port = free_port();
  CasdFixture fixture(kFcuOnly + "  - {name: net, type: udp, remote: \"127.0.0.1:" +
                      std::to_string(port) + "\"}\n");
  // There is no listener yet: these packets bring ICMP errors.
  for (std::uint64_t i = 1; i <= 5; ++i) fixture.fcu.write(fixture.from_fcu(hil_controls(i)));
  ASSERT_TRUE(wait_until([&] { return fixture.status("net").tx.packets == 5; }));
  AnyUdpPeer station("127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(station.bound());
  fixture.fcu.write(fixture.from_fcu(hil_controls(6)));
  PacketStream heard;
  ASSERT_TRUE(wait_until([&] {
    station.read(heard);
    return heard.count(kHilControls) == 1;
  }));
  EXPECT_EQ(numbers(heard, kHilControls), std::vector<std::uint64_t>{6});
}

}  // namespace
}  // namespace cas::test

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/peer_table.hpp"

#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::seconds;

constexpr LinkId kOwn = 5;

sockaddr_storage on_port(std::uint16_t port) {
  sockaddr_storage storage{};
  auto& v4 = reinterpret_cast<sockaddr_in&>(storage);
  v4.sin_family = AF_INET;
  v4.sin_port = htons(port);
  return storage;
}

sockaddr_storage on_host(std::uint32_t host, std::uint16_t port) {
  sockaddr_storage storage = on_port(port);
  reinterpret_cast<sockaddr_in&>(storage).sin_addr.s_addr = htonl(host);
  return storage;
}

/// Stations 100, 101, ... on ports 1000, 1001, ...
struct FilledTable : PeerTable {
  explicit FilledTable(int filled, int most = 64) : PeerTable(most, seconds(30)) {
    for (int i = 0; i < filled; ++i) {
      const auto peer =
          add(on_port(static_cast<std::uint16_t>(1000 + i)), sizeof(sockaddr_in), at({}));
      if (peer) heard(*peer, {static_cast<std::uint8_t>(100 + i), 190}, at({}));
    }
  }
};

TEST(PeerTable, KnowsItsPeersByAddress) {
  const FilledTable peers(3);
  EXPECT_EQ(peers.find(on_port(1001)), 1);
  EXPECT_FALSE(peers.find(on_port(999)));
}

TEST(PeerTable, HoldsSixtyFourAndNoMore) {
  FilledTable peers(64);
  EXPECT_EQ(peers.count(), 64);
  EXPECT_FALSE(peers.add(on_port(9), sizeof(sockaddr_in), at({})));
}

TEST(PeerTable, NewPeerTakesThePlaceOfASilentOne) {
  FilledTable peers(2, 2);
  peers.heard(0, {100, 190}, at(seconds(31)));
  EXPECT_EQ(peers.add(on_port(9), sizeof(sockaddr_in), at(seconds(31))), 1);
  EXPECT_FALSE(peers.find(on_port(1001)));
}

TEST(PeerTable, TheMachineWithMostPeersGivesWayToOneWithFewer) {
  FilledTable peers(64);
  const auto add = [&](std::uint32_t host, std::uint16_t port) {
    return peers.add(on_host(host, port), sizeof(sockaddr_in), at({}));
  };
  EXPECT_EQ(add(7, 9), 63) << "in the place of the newest";
  EXPECT_FALSE(peers.find(on_port(1063)));
  for (std::uint16_t port = 10; port < 40; ++port) EXPECT_TRUE(add(7, port)) << port;
  EXPECT_TRUE(add(7, 40)) << "half of the places";
  EXPECT_FALSE(add(7, 41));
  EXPECT_FALSE(add(0, 9)) << "nor has the other one fewer";
  EXPECT_TRUE(add(8, 9));
  EXPECT_TRUE(peers.find(on_port(1000))) << "an old station stays";
  EXPECT_EQ(peers.count(), 64);
}

PacketInfo addressed(mav::Source target) {
  PacketInfo result;
  result.target = target;
  return result;
}

TEST(PeerTable, BroadcastReachesAllAndAddressedPacketsTheirPeer) {
  const FilledTable peers(3);
  EXPECT_EQ(peers.for_packet(addressed({0, 0}), kOwn), 0b111U);
  EXPECT_EQ(peers.for_packet(addressed({102, 0}), kOwn), 0b100U);
  EXPECT_EQ(peers.for_packet(addressed({9, 9}), kOwn), 0U);
}

TEST(PeerTable, NothingGoesBackToTheSendingPeer) {
  const FilledTable peers(3);
  PacketInfo packet = addressed({0, 0});
  packet.from = kOwn;
  packet.from_peer = 1;
  EXPECT_EQ(peers.for_packet(packet, kOwn), 0b101U);
}

TEST(PeerTable, APacketForOnePeerGoesToNoOtherAndToNoLaterOneOfItsSlot) {
  FilledTable peers(2);
  PacketInfo packet;
  packet.to_serial = peers.id(1).serial;
  EXPECT_EQ(peers.for_packet(packet, kOwn), 2U);
  peers.clear();
  EXPECT_EQ(peers.add(on_port(9), sizeof(sockaddr_in), at({})), 0);
  EXPECT_EQ(peers.add(on_port(10), sizeof(sockaddr_in), at({})), 1);
  EXPECT_EQ(peers.for_packet(packet, kOwn), 0U);
}

TEST(PeerTable, ForgetsSilentPeersAndTheirRoutes) {
  FilledTable peers(2);
  peers.heard(1, {101, 190}, at(seconds(20)));
  EXPECT_EQ(peers.expire(at(seconds(31))), 1);
  EXPECT_EQ(peers.for_packet(addressed({0, 0}), kOwn), 0b10U);
  EXPECT_EQ(peers.for_packet(addressed({100, 190}), kOwn), 0U);
}

TEST(PeerTable, KeepsAPeerThatBringsAVehicleOverASatellite) {
  FilledTable peers(2);
  peers.heard(1, {101, 190}, at({}), true);
  EXPECT_EQ(peers.expire(at(seconds(199))), 1);
  EXPECT_EQ(peers.for_packet(addressed({101, 190}), kOwn), 0b10U);
  EXPECT_EQ(peers.expire(at(seconds(201))), 1);
}

}  // namespace
}  // namespace cas::casd::test

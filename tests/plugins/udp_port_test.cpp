// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/udp_port.hpp"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/plugins/datagram_peer.hpp"

namespace cas::sim {
namespace {

using std::chrono::milliseconds;
using Peer = test::DatagramPeer;

constexpr base::Duration kPatience = std::chrono::seconds(10);  // deadline, not a wait

base::ConfigNode scalar(const std::string& text) {
  return base::ConfigNode::parse("a: " + text).at("a");
}

constexpr std::array<std::uint8_t, 3> kThreeBytes{1, 2, 3};

TEST(UdpPort, SendsAndReceivesWithTheMomentOfArrival) {
  Peer peer;
  UdpPort port(scalar("127.0.0.1:0"), scalar(peer.endpoint()));
  ASSERT_TRUE(port.send(kThreeBytes));
  EXPECT_EQ(peer.receive(), (std::vector<std::uint8_t>{1, 2, 3}));

  const base::RunTime before = base::steady_now();
  for (int i = 0; i < 40; ++i) peer.send_to(port.endpoint(), kThreeBytes);  // more than one batch
  ASSERT_TRUE(port.wait(kPatience));
  int datagrams = 0;
  constexpr base::Duration kClockReading = milliseconds(5);  // two clocks are read, not one
  port.poll([&](std::span<const std::uint8_t> bytes, base::RunTime at) {
    EXPECT_EQ(bytes.size(), 3U);
    EXPECT_GE(at, before - kClockReading);
    EXPECT_LE(at, base::steady_now());
    ++datagrams;
  });
  EXPECT_EQ(datagrams, 40);
}

TEST(UdpPort, ListensToItsPeerOnly) {
  Peer peer;
  Peer stranger;
  UdpPort port(scalar("127.0.0.1:0"), scalar(peer.endpoint()));
  stranger.send_to(port.endpoint(), kThreeBytes);
  ASSERT_TRUE(port.wait(kPatience));
  port.poll([](std::span<const std::uint8_t>, base::RunTime) { ADD_FAILURE() << "a stranger"; });
  nlohmann::ordered_json figures;
  port.add_figures(figures);
  EXPECT_EQ(figures["foreign_datagrams"], 1);
}

TEST(UdpPort, WithoutARemoteAnswersWhoeverSpeaksFirst) {
  Peer peer;
  UdpPort port(scalar("127.0.0.1:0"), std::nullopt);
  EXPECT_FALSE(port.send(kThreeBytes));
  peer.send_to(port.endpoint(), kThreeBytes);
  ASSERT_TRUE(port.wait(kPatience));
  port.poll([](std::span<const std::uint8_t>, base::RunTime) {});
  EXPECT_TRUE(port.send(kThreeBytes));
  EXPECT_EQ(peer.receive().size(), 3U);
}

TEST(UdpPort, APeerThatIsNotThereCostsNothing) {
  std::string nobody;
  {
    Peer gone;
    nobody = gone.endpoint();
  }
  UdpPort port(scalar("127.0.0.1:0"), scalar(nobody));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(port.send(kThreeBytes));
}

TEST(UdpPort, RefusesWhatIsNoAddress) {
  EXPECT_THROW(UdpPort(scalar("nonsense"), std::nullopt), base::ConfigError);
  EXPECT_THROW(UdpPort(scalar("127.0.0.1:notaport"), std::nullopt), base::ConfigError);
  UdpPort first(scalar("127.0.0.1:0"), std::nullopt);
  EXPECT_THROW(UdpPort(scalar(first.endpoint().substr(4)), std::nullopt), base::ConfigError);
}

}  // namespace
}  // namespace cas::sim

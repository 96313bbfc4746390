// SPDX-License-Identifier: BSD-3-Clause
// A name with several addresses, of which one answers: `localhost` is ::1 and 127.0.0.1.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "casd/transport/socket_address.hpp"
#include "tests/loopback/any_udp_peer.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/tcp_peer.hpp"

namespace cas::test {
namespace {

const std::string kFcuOnly = "schema: 1\nlinks:\n  - {name: fcu, type: serial, device: \"$FCU\"}\n";

/// 127.0.0.1 or [::1], both of which `localhost` may stand for.
class LocalhostAt : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const casd::AddressLookup localhost("localhost:0");
    ASSERT_TRUE(
        wait_until([&] { return localhost.state() != casd::AddressLookup::State::kPending; }));
    ASSERT_EQ(localhost.state(), casd::AddressLookup::State::kFound);
    const casd::SocketAddress wanted = casd::AddressLookup(GetParam() + ":0").address();
    const auto& all = localhost.addresses();
    if (std::ranges::find(all, wanted) == all.end())
      GTEST_SKIP() << "localhost is not " << GetParam();
  }
  /// Packets of the line until the condition holds.
  template <class Condition>
  bool send_until(Condition&& condition) {
    std::uint64_t number = 0;
    return fixture_.collect_until([&] {
      fixture_.fcu.write(fixture_.from_fcu(hil_controls(++number)));
      return condition();
    });
  }

  CasdFixture fixture_;
  PacketStream heard_;
};

TEST_P(LocalhostAt, IsFoundByUdp) {
  AnyUdpPeer station(GetParam() + ":0");
  ASSERT_TRUE(station.bound());
  const std::string port = station.endpoint().substr(station.endpoint().rfind(':'));
  fixture_.start(kFcuOnly + "  - {name: net, type: udp, remote: \"localhost" + port + "\"}\n");
  EXPECT_TRUE(send_until([&] {
    station.read(heard_);
    return heard_.count(kHilControls) >= 3;
  })) << fixture_.status("net").endpoint;
}

TEST_P(LocalhostAt, IsFoundByUdpFromAConfiguredPort) {
  AnyUdpPeer station(GetParam() + ":0");
  const std::string port = station.endpoint().substr(station.endpoint().rfind(':'));
  fixture_.start(kFcuOnly +
                 "  - {name: net, type: udp, local: \"localhost:0\", remote: \"localhost" + port +
                 "\"}\n");
  EXPECT_TRUE(send_until([&] {
    station.read(heard_);
    return heard_.count(kHilControls) >= 3;
  })) << fixture_.status("net").endpoint;
}

TEST_P(LocalhostAt, IsServedByAUdpServer) {
  fixture_.start(kFcuOnly + "  - {name: net, type: udp_server, local: \"localhost:0\"}\n");
  ASSERT_TRUE(wait_until([&] { return fixture_.status("net").state == casd::LinkState::kUp; }));
  AnyUdpPeer station(GetParam() + ":0");
  mav::Encoder sender({255, 190});
  const std::string port = std::to_string(fixture_.port("net"));
  EXPECT_TRUE(send_until([&] {
    station.send(GetParam() + ":" + port, sender(mavlink::common::Heartbeat{}));
    station.read(heard_);
    return heard_.count(kHilControls) >= 3 && fixture_.at_fcu.count(kHeartbeat) >= 3;
  })) << fixture_.status("net").endpoint;
}

INSTANTIATE_TEST_SUITE_P(Families, LocalhostAt, testing::Values("127.0.0.1", "[::1]"),
                         [](const auto& test) { return test.param[0] == '[' ? "V6" : "V4"; });

TEST(CasdNames, ATcpServerOfAnyAddressIsFound) {
  const TcpListener listener;
  const std::string port = listener.endpoint().substr(listener.endpoint().rfind(':'));
  CasdFixture fixture(kFcuOnly + "  - {name: net, type: tcp, remote: \"localhost" + port + "\"}\n");
  const int accepted = listener.accept();
  ASSERT_GE(accepted, 0) << fixture.status("net").endpoint;
  TcpPeer server(accepted, true);
  PacketStream heard;
  EXPECT_TRUE(fixture.collect_until([&] {
    fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
    server.read(heard);
    return heard.count(kHilControls) >= 3;
  }));
}

TEST(CasdNames, ATcpServerLinkTakesClientsAtEachAddress) {
  CasdFixture fixture(kFcuOnly + "  - {name: net, type: tcp_server, local: \"localhost:0\"}\n");
  ASSERT_TRUE(wait_until([&] { return fixture.status("net").state == casd::LinkState::kUp; }));
  TcpPeer client(fixture.port("net"));  // at 127.0.0.1
  EXPECT_TRUE(client.connected()) << fixture.status("net").endpoint;
}

}  // namespace
}  // namespace cas::test

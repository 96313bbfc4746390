// SPDX-License-Identifier: BSD-3-Clause
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

struct Station {
  explicit Station(std::uint8_t system) : encoder({system, 190}) {}
  UdpPeer socket;
  PacketStream heard;
  mav::Encoder encoder;
};

std::string servers(const std::string& expiry_s) {
  return R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$FCU"}
  - {name: gcs, type: udp_server, local: "127.0.0.1:0", expiry_s: )" +
         expiry_s + R"(}
  - {name: tcp, type: tcp_server, local: "127.0.0.1:0"}
)";
}
const std::string kServers = servers("60");

constexpr mav::Source kCasd{254, 190};

/// The sequence numbers of casd's own packets, as they came.
std::vector<std::uint8_t> numbers_of_casd(PacketStream& heard) {
  std::vector<std::uint8_t> all;
  for (const auto& packet : heard.packets()) {
    if (packet.source == kCasd) all.push_back(packet.sequence);
  }
  return all;
}

TEST(CasdOwnPackets, LookLikeALossToNoPeerThoughOthersGetMore) {
  CasdFixture fixture(kServers);
  Station first(1);
  Station second(2);
  TcpPeer client(fixture.port("tcp"));
  PacketStream at_client;
  mav::Encoder of_client({255, 190});
  for (Station* each : {&first, &second}) {
    each->socket.set_remote(fixture.port("gcs"));
    each->socket.send(each->encoder(mavlink::common::Heartbeat{}));
  }
  client.send(of_client(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) == 3; }));

  constexpr std::size_t kBroadcasts = 10;
  mav::Encoder casd(kCasd);
  const auto send = [&](const auto& message) {
    fixture.links().local().send(casd(message), {}, base::steady_now());
  };
  for (std::size_t i = 0; i < kBroadcasts; ++i) {
    mavlink::common::CommandLong command{.target_system = 1};
    for (int repeat = 0; repeat < 7; ++repeat) send(command);
    send(mavlink::common::Heartbeat{});
  }
  const auto all_came = [&](PacketStream& heard, std::size_t packets) {
    const std::vector<std::uint8_t> came = numbers_of_casd(heard);
    if (came.size() < packets) return false;
    for (std::size_t i = 1; i < packets; ++i) {
      EXPECT_EQ(came[i], static_cast<std::uint8_t>(came[i - 1] + 1)) << i;
    }
    return true;
  };
  EXPECT_TRUE(fixture.collect_until([&] {
    first.socket.read(first.heard);
    second.socket.read(second.heard);
    client.read(at_client);
    return numbers_of_casd(first.heard).size() == 8 * kBroadcasts &&
           numbers_of_casd(second.heard).size() == kBroadcasts &&
           numbers_of_casd(at_client).size() == kBroadcasts &&
           numbers_of_casd(fixture.at_fcu).size() == kBroadcasts;
  }));
  EXPECT_TRUE(all_came(first.heard, 8 * kBroadcasts));
  EXPECT_TRUE(all_came(second.heard, kBroadcasts));
  EXPECT_TRUE(all_came(at_client, kBroadcasts));
  EXPECT_TRUE(all_came(fixture.at_fcu, kBroadcasts));
}

TEST(CasdTcpServer, ASilentClientMakesRoomForAStationButNoStationForASilentOne) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: fcu, type: serial, device: "$FCU"}
  - {name: tcp, type: tcp_server, local: "127.0.0.1:0", max_peers: 2}
)");
  const std::uint16_t port = fixture.port("tcp");
  mav::Encoder station({255, 190});
  const auto peers = [&](std::uint64_t count) {
    return wait_until([&] { return fixture.status("tcp").peers == count; });
  };
  TcpPeer silent(port);
  TcpPeer half(port);
  half.send(std::vector<std::uint8_t>{0xFD});
  ASSERT_TRUE(peers(2));
  TcpPeer first(port);
  first.send(station(mavlink::common::Heartbeat{}));
  TcpPeer second(port);
  second.send(station(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) == 2; }));
  EXPECT_EQ(fixture.status("tcp").peers, 2U);
  PacketStream nothing;
  TcpPeer late(port);
  EXPECT_TRUE(wait_until([&] {
    late.read(nothing);
    return late.closed();
  }));
  first.read(nothing);
  second.read(nothing);
  EXPECT_FALSE(first.closed() || second.closed());
}

TEST(CasdUdpServer, Serves64StationsOnOnePort) {
  CasdFixture fixture(kServers);
  std::vector<std::unique_ptr<Station>> stations;
  for (std::uint8_t i = 0; i < 64; ++i) {
    stations.push_back(std::make_unique<Station>(static_cast<std::uint8_t>(100 + i)));
    stations.back()->socket.set_remote(fixture.port("gcs"));
  }
  const auto everyone = [&](std::size_t packets) {
    return fixture.collect_until([&] {
      bool all = true;
      for (auto& station : stations) {
        station->socket.send(station->encoder(mavlink::common::Heartbeat{}));
        station->socket.read(station->heard);
        all = all && station->heard.count(kHilControls) >= packets;
      }
      return all;
    });
  };
  ASSERT_TRUE(fixture.collect_until([&] {
    for (auto& station : stations) {
      station->socket.send(station->encoder(mavlink::common::Heartbeat{}));
    }
    return fixture.status("gcs").peers == 64;
  }));
  std::vector<std::uint8_t> burst;
  for (std::uint64_t i = 1; i <= 20; ++i) {
    const auto packet = fixture.from_fcu(hil_controls(i));
    burst.insert(burst.end(), packet.begin(), packet.end());
  }
  fixture.fcu.write(burst);
  ASSERT_TRUE(everyone(20));
  for (auto& station : stations) {
    EXPECT_EQ(station->heard.count(kHilControls), 20U);
    EXPECT_EQ(station->heard.garbage(), 0U);
  }
  // A 65th finds no room and is counted.
  Station late(7);
  late.socket.set_remote(fixture.port("gcs"));
  late.socket.send(late.encoder(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(everyone(20) && wait_until([&] { return fixture.status("gcs").rx.foreign > 0; }));
  EXPECT_EQ(fixture.status("gcs").peers, 64U);
}

TEST(CasdUdpServer, CountsAsSentOnlyWhatAPeerWasSent) {
  for (const bool signs : {false, true}) {
    CasdFixture fixture;
    const cas::test::TemporaryFolder folder;
    const std::string key = folder.write("radio.key", "a pass phrase of the laboratory\n");
    std::filesystem::permissions(
        key, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    fixture.start(R"(schema: 1
commanding: {heartbeat_hz: 0}
links:
  - {name: fcu, type: serial, device: "$FCU"}
  - {name: gcs, type: udp_server, local: "127.0.0.1:0")" +
                  (signs ? ", signing: {key_file: " + key + ", verify: false}}\n" : "}\n"));
    const auto send = [&](std::uint64_t first) {  // one alone, then several in one look
      fixture.fcu.write(fixture.from_fcu(hil_controls(first)));
      std::vector<std::uint8_t> burst;
      for (std::uint64_t i = 1; i <= 9; ++i) {
        const auto packet = fixture.from_fcu(hil_controls(first + i));
        burst.insert(burst.end(), packet.begin(), packet.end());
      }
      fixture.fcu.write(burst);
    };
    send(1);
    ASSERT_TRUE(wait_until([&] { return fixture.status("fcu").rx.packets == 10; }));
    EXPECT_EQ(fixture.status("gcs").tx.packets, 0U);

    Station station(101);
    station.socket.set_remote(fixture.port("gcs"));
    station.socket.send(station.encoder(mavlink::common::Heartbeat{}));
    ASSERT_TRUE(wait_until([&] { return fixture.status("gcs").peers == 1; }));
    send(11);
    ASSERT_TRUE(fixture.collect_until([&] {
      station.socket.read(station.heard);
      return station.heard.count(kHilControls) == 10;
    }));
    EXPECT_TRUE(wait_until([&] { return fixture.status("gcs").tx.packets >= 10; }));
    EXPECT_EQ(fixture.status("gcs").tx.packets, 10U);
  }
}

TEST(CasdUdpServer, SendsAddressedPacketsToTheirPeerAloneAndForgetsSilentOnes) {
  CasdFixture fixture(servers("4"));
  Station one(101);
  Station other(102);
  for (Station* station : {&one, &other}) {
    station->socket.set_remote(fixture.port("gcs"));
    station->socket.send(station->encoder(mavlink::common::Heartbeat{}));
  }
  ASSERT_TRUE(wait_until([&] { return fixture.status("gcs").peers == 2; }));
  mavlink::common::CommandAck ack{.target_system = 102, .target_component = 190};
  fixture.fcu.write(fixture.from_fcu(ack));
  fixture.fcu.write(fixture.from_fcu(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(fixture.collect_until([&] {
    one.socket.read(one.heard);
    other.socket.read(other.heard);
    return one.heard.count(kHeartbeat) > 0 && other.heard.count(kHeartbeat) > 0;
  }));
  EXPECT_EQ(one.heard.count(mavlink::common::CommandAck::kId), 0U);
  EXPECT_EQ(other.heard.count(mavlink::common::CommandAck::kId), 1U);
  EXPECT_TRUE(wait_until([&] { return fixture.status("gcs").peers == 0; }));
}

TEST(CasdUdpServer, LetsItsPeersTalkWhenARouteSaysSo) {
  CasdFixture fixture(kServers + "routes:\n  - {from: gcs, to: gcs}\n");
  Station one(101);
  Station other(102);
  for (Station* station : {&one, &other}) station->socket.set_remote(fixture.port("gcs"));
  ASSERT_TRUE(fixture.collect_until([&] {
    for (Station* station : {&one, &other}) {
      station->socket.send(station->encoder(mavlink::common::Heartbeat{}));
      station->socket.read(station->heard);
    }
    return !one.heard.packets().empty() && !other.heard.packets().empty();
  }));
  for (const auto& packet : one.heard.packets()) EXPECT_EQ(packet.source.system, 102);
  for (const auto& packet : other.heard.packets()) EXPECT_EQ(packet.source.system, 101);
}

TEST(CasdTcpServer, ServesSeveralClientsAndCostsNobodyAStalledOne) {
  CasdFixture fixture(kServers);
  TcpPeer stalled(fixture.port("tcp"), 4096);
  TcpPeer client(fixture.port("tcp"));
  ASSERT_TRUE(stalled.connected() && client.connected());
  ASSERT_TRUE(wait_until([&] { return fixture.status("tcp").peers == 2; }));

  // Until the stalled one is given up, every packet reaches the other.
  PacketStream heard;
  std::uint64_t sent = 0;
  ASSERT_TRUE(fixture.collect_until([&] {
    for (int i = 0; i < 20; ++i) fixture.fcu.write(fixture.from_fcu(hil_controls(++sent)));
    const bool kept_up = wait_until([&] {
      client.read(heard);
      return heard.count(kHilControls) == sent;
    });
    EXPECT_TRUE(kept_up);
    return fixture.status("tcp").peers == 1;
  }));
  const auto status = fixture.status("tcp");
  EXPECT_GT(status.tx.dropped[static_cast<std::size_t>(casd::DropCause::kStalled)] +
                status.tx.dropped[static_cast<std::size_t>(casd::DropCause::kAge)],
            0U);

  // Both ways.
  mav::Encoder from_client({255, 190});
  client.send(from_client(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) == 1; }));
}

TEST(CasdTcpServerStranger, IsClosedUnreadAndCounted) {
  /// Bytes that a program other than a station sends first, before a whole packet that arms.
  struct StrangerCase {
    const char* name;
    std::string first;
  };
  const StrangerCase rows[] = {{"HttpPost", "POST / HTTP/1.1\r\nContent-Length: 21\r\n\r\n"},
                               {"WebSocketUpgrade", "GET / HTTP/1.1\r\nUpgrade: websocket\r\n\r\n"},
                               {"EmptyLineFirst", "\r\nPUT / HTTP/1.1\r\n\r\n"},
                               {"TlsClientHello", std::string("\x16\x03\x01\x02\x00", 5)},
                               {"Utf8Mark", "\xEF\xBB\xBFhello"},
                               {"Zero", std::string(1, '\0')}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    CasdFixture fixture(kServers);
    TcpPeer stranger(fixture.port("tcp"));
    mav::Encoder encoder({255, 190});
    const auto packet = encoder(mavlink::common::Heartbeat{});
    std::vector<std::uint8_t> bytes(row.first.begin(), row.first.end());
    bytes.insert(bytes.end(), packet.begin(), packet.end());
    stranger.send(bytes);
    PacketStream heard;
    ASSERT_TRUE(fixture.collect_until([&] {
      stranger.read(heard);
      return stranger.closed() || fixture.status("tcp").rx.foreign > 0;
    }));
    ASSERT_TRUE(wait_until([&] { return fixture.status("tcp").peers == 0; }));
    EXPECT_EQ(fixture.status("tcp").rx.foreign, 1U);
    EXPECT_EQ(fixture.status("tcp").rx.bytes, 0U) << "nothing of it was parsed";

    // A station beside it is served.
    TcpPeer station(fixture.port("tcp"));
    station.send(packet);
    ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) > 0; }));
    EXPECT_EQ(fixture.at_fcu.count(kHeartbeat), 1U);
  }
}

TEST(CasdTcp, ConnectsAgainWhenTheServerComesBack) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  CasdFixture fixture(
      "schema: 1\nlinks:\n  - {name: fcu, type: serial, device: \"$FCU\"}\n"
      "  - {name: net, type: tcp, remote: \"localhost:" +
      std::to_string(ntohs(address.sin_port)) + "\"}\n");
  EXPECT_NE(fixture.status("net").state, casd::LinkState::kUp);  // no listener yet
  ::listen(listener, 4);
  for (std::uint64_t round = 1; round <= 2; ++round) {
    pollfd waiting{listener, POLLIN, 0};
    ASSERT_EQ(::poll(&waiting, 1, 20000), 1);
    TcpPeer server(::accept(listener, nullptr, nullptr), true);
    PacketStream heard;
    ASSERT_TRUE(fixture.collect_until([&] {
      fixture.fcu.write(fixture.from_fcu(hil_controls(round)));
      server.read(heard);
      return heard.count(kHilControls) > 0;
    }));
    EXPECT_EQ(numbers(heard, kHilControls).front(), round);
  }
  ::close(listener);
}

TEST(CasdTcp, CallsAServerThatClosesAtOnceNoMoreOftenThanOneThatIsAway) {
  const TcpListener listener;
  CasdFixture fixture(
      "schema: 1\nlinks:\n  - {name: net, type: tcp, remote: \"" + listener.endpoint() + "\"}\n",
      {std::chrono::milliseconds(500), std::chrono::minutes(1)});
  constexpr int kCalls = 4;
  base::RunTime first{};
  for (int call = 1; call <= kCalls; ++call) {
    const int accepted = listener.accept();
    ASSERT_GE(accepted, 0);
    const TcpPeer closes(accepted, true);
    if (call == 1) first = base::steady_now();
  }
  // 0.5, 1 and 2 s lie between them; without the back-off 0.5 s each.
  EXPECT_GT(base::steady_now() - first, std::chrono::seconds(2));
}

}  // namespace
}  // namespace cas::test

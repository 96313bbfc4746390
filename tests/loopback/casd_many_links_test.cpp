// SPDX-License-Identifier: BSD-3-Clause
// As many links as casd takes, on real sockets.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "casd/packet/link_id.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/ended_with.hpp"

namespace cas::test {
namespace {

using mavlink::common::Attitude;
using nlohmann::json;

constexpr int kLinks = casd::kMaxLinks;

std::string name_of(int link) { return "l" + std::to_string(link); }

/// The other end of a link; every third link is of the same kind.
class End {
 public:
  enum class Kind { kUdp, kUdpServer, kTcpServer };
  explicit End(int link) : kind_(static_cast<Kind>(link % 3)) {}

  /// Its entry of `links`.
  std::string entry(const std::string& name) const {
    const std::string head = "  - {name: " + name + ", type: ";
    switch (kind_) {
      case Kind::kUdp:
        return head + "udp, remote: \"" + udp_.endpoint() + "\"}\n";
      case Kind::kUdpServer:
        return head + "udp_server, local: \"127.0.0.1:0\"}\n";
      case Kind::kTcpServer:
        return head + "tcp_server, local: \"127.0.0.1:0\"}\n";
    }
    return "";
  }
  void open(std::uint16_t port) {
    udp_.set_remote(port);
    if (kind_ == Kind::kTcpServer) tcp_.emplace(port);
  }
  void send(std::span<const std::uint8_t> bytes) {
    if (tcp_) {
      tcp_->send(bytes);
    } else {
      udp_.send(bytes);
    }
  }
  /// The numbers of the ATTITUDE messages that have come.
  const std::vector<std::uint32_t>& heard() {
    if (tcp_) {
      tcp_->read(stream_);
    } else {
      udp_.read(stream_);
    }
    for (; !stream_.packets().empty(); stream_.packets().pop_front()) {
      const auto attitude = mav::decode<Attitude>(stream_.packets().front().view());
      if (attitude) heard_.push_back(attitude->time_boot_ms);
    }
    return heard_;
  }

 private:
  Kind kind_;
  UdpPeer udp_;
  std::optional<TcpPeer> tcp_;
  PacketStream stream_;
  std::vector<std::uint32_t> heard_;
};

class CasdManyLinks : public testing::Test {
 protected:
  /// Each link sends to the next one, the last to the first, and to no other.
  void start() {
    std::string links = "links:\n";
    std::string routes = "routes:\n";
    for (int i = 0; i < kLinks; ++i) {
      ends_.push_back(std::make_unique<End>(i));
      links += ends_.back()->entry(name_of(i));
      routes += "  - {from: " + name_of(i) + ", to: " + name_of((i + 1) % kLinks) + "}\n";
    }
    const auto file = folder_.write(
        "many.yaml",
        "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\nmetrics: {port: 0}\n"
        "commanding: {heartbeat_hz: 0}\n" +
            links + routes);
    casd_.emplace(std::vector<std::string>{kCasdProgram, file});
  }
  json links() { return casd_->call("link.list"); }

  /// Connects the ends and makes each of them known to its link.
  void open_ends() {
    ASSERT_TRUE(wait_until([&] {
      const json all = links();
      return std::ranges::all_of(all, [](const json& link) { return link["state"] == "up"; });
    }));
    const json all = links();
    for (const json& link : all) {
      const int i = std::stoi(link["name"].get<std::string>().substr(1));
      ends_[static_cast<std::size_t>(i)]->open(port_of(link["endpoint"]));
    }
    mavlink::common::Heartbeat station;
    station.type = mavlink::common::MavType::kGcs;
    station.autopilot = mavlink::common::MavAutopilot::kInvalid;
    mav::Encoder encoder{{255, 190}};
    for (const auto& end : ends_) end->send(encoder(station));
    ASSERT_TRUE(wait_until([&] {
      const json now = links();
      return std::ranges::all_of(now, [](const json& link) { return link["rx"]["packets"] > 0; });
    }));
  }

  TemporaryFolder folder_;
  std::vector<std::unique_ptr<End>> ends_;
  std::optional<RunningCasd> casd_;
};

TEST_F(CasdManyLinks, RoutesEachPacketToItsLinkAloneAndShowsThemAll) {
  start();
  ASSERT_EQ(links().size(), static_cast<std::size_t>(kLinks));
  open_ends();
  for (int i = 0; i < kLinks; ++i) {
    Attitude attitude;
    attitude.time_boot_ms = static_cast<std::uint32_t>(i);
    mav::Encoder encoder{{static_cast<std::uint8_t>(1 + i), 1}};
    ends_[static_cast<std::size_t>(i)]->send(encoder(attitude));
  }
  for (int i = 0; i < kLinks; ++i) {
    End& next = *ends_[static_cast<std::size_t>((i + 1) % kLinks)];
    EXPECT_TRUE(wait_until([&] { return !next.heard().empty(); })) << name_of(i);
  }
  for (int i = 0; i < kLinks; ++i) {
    const std::vector<std::uint32_t> its{static_cast<std::uint32_t>(i)};
    EXPECT_EQ(ends_[static_cast<std::size_t>((i + 1) % kLinks)]->heard(), its);
  }

  const json status = casd_->call("casd.status");
  EXPECT_EQ(status["links"].size(), static_cast<std::size_t>(kLinks));
  base::rpc::RawClient http(casd_->port("metrics"));
  ASSERT_TRUE(http.send("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n"));
  int shown = 0;
  while (const auto line = http.line()) shown += line->starts_with("casd_link_up{") ? 1 : 0;
  EXPECT_EQ(shown, kLinks);
}

TEST_F(CasdManyLinks, OneMoreIsRefusedByItsNumber) {
  std::string links = "schema: 1\nlinks:\n";
  for (int i = 0; i <= kLinks; ++i) links += End(2).entry(name_of(i));
  EXPECT_THAT(ChildProcess({kCasdProgram, "--check", folder_.write("more.yaml", links)}).end(),
              EndedWith(base::kExitConfig, "more than 250 links"));
}

}  // namespace
}  // namespace cas::test

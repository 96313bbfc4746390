// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/tcp_server_port.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "mavlink/common/all.hpp"
#include "plugins/mavlink_interface/hil_interface.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
constexpr std::array<std::uint8_t, 3> kThree{mav::kStartV2, 2, 3};

/// A TCP connection to the port, blocking.
class Client {
 public:
  explicit Client(const TcpServerPort& port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const std::string endpoint = port.endpoint();
    const auto number =
        static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
    const InetAddress to = InetAddress::loopback(number);
    EXPECT_EQ(::connect(socket_, to.data(), to.size()), 0);
  }
  ~Client() { close(socket_); }
  void send(std::span<const std::uint8_t> bytes) {
    EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  }
  std::vector<std::uint8_t> receive(std::size_t size) {
    std::vector<std::uint8_t> bytes(size);
    EXPECT_EQ(::recv(socket_, bytes.data(), size, MSG_WAITALL), static_cast<ssize_t>(size));
    return bytes;
  }

 private:
  int socket_;
};

std::size_t poll_bytes(TcpServerPort& port) {
  std::size_t total = 0;
  port.poll([&](std::span<const std::uint8_t> bytes, base::RunTime) { total += bytes.size(); });
  return total;
}

TEST(TcpServerPort, ServesOneClientAfterTheOther) {
  TcpServerPort port(InetAddress::loopback(0));
  EXPECT_FALSE(port.connected());
  EXPECT_FALSE(port.send(kThree));
  for (std::uint64_t visit = 1; visit <= 3; ++visit) {
    {
      Client client(port);
      ASSERT_TRUE(test::wait_until([&] {
        poll_bytes(port);
        return port.connected();
      }));
      EXPECT_EQ(port.peers(), visit);
      EXPECT_TRUE(port.send(kThree));
      EXPECT_EQ(client.receive(3), (std::vector<std::uint8_t>{mav::kStartV2, 2, 3}));
      client.send(kThree);
      EXPECT_TRUE(port.wait(test::kPatience));
      EXPECT_EQ(poll_bytes(port), 3U);
    }
    ASSERT_TRUE(test::wait_until([&] {
      poll_bytes(port);
      return !port.connected();
    }));
  }
}

TEST(TcpServerPort, ClosesAClientThatBeginsWithNoPacketAndServesTheNext) {
  TcpServerPort port(InetAddress::loopback(0));
  for (const std::string_view first : {"POST / HTTP/1.1\r\n\r\n\xFD", "\r\n\xFD", "\x16\x03\x01"}) {
    Client page(port);
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(first.data());
    page.send({bytes, first.size()});
    nlohmann::ordered_json before;
    port.add_figures(before);
    ASSERT_TRUE(test::wait_until([&] {
      EXPECT_EQ(poll_bytes(port), 0U);
      nlohmann::ordered_json figures;
      port.add_figures(figures);
      return figures["refused_clients"] > before["refused_clients"];
    }));
    EXPECT_FALSE(port.connected());
  }
  Client firmware(port);
  firmware.send(kThree);
  std::size_t taken = 0;
  ASSERT_TRUE(test::wait_until([&] {
    taken += poll_bytes(port);
    return taken == kThree.size();
  }));
}

TEST(TcpServerPort, ASilentClientKeepsNobodyOut) {
  TcpServerPort port(InetAddress::loopback(0), base::Duration::zero());
  Client silent(port);
  ASSERT_TRUE(test::wait_until([&] {
    poll_bytes(port);
    return port.connected();
  }));
  poll_bytes(port);
  EXPECT_TRUE(port.connected()) << "nobody else wants its place";
  Client firmware(port);
  firmware.send(kThree);
  std::size_t taken = 0;
  ASSERT_TRUE(test::wait_until([&] {
    taken += poll_bytes(port);
    return taken == kThree.size();
  }));
  const Client next(port);
  poll_bytes(port);
  poll_bytes(port);
  EXPECT_EQ(port.peers(), 2U) << "a client that has spoken stays";
}

TEST(TcpServerPort, DropsWholePacketsWhenTheClientDoesNotRead) {
  TcpServerPort port(InetAddress::loopback(0));
  Client client(port);
  ASSERT_TRUE(test::wait_until([&] {
    poll_bytes(port);
    return port.connected();
  }));
  std::array<std::uint8_t, 280> packet;
  std::size_t taken = 0;
  packet.fill(0);
  while (port.send(packet)) packet.fill(static_cast<std::uint8_t>(++taken));
  // Accepted packets arrive without a gap, also the packet that went in two parts.
  for (std::size_t i = 0; i < taken; ++i) {
    const auto bytes = client.receive(packet.size() - (i + 1 == taken ? 279 : 0));
    ASSERT_EQ(bytes.front(), static_cast<std::uint8_t>(i));
    ASSERT_EQ(bytes.back(), static_cast<std::uint8_t>(i));
  }
  nlohmann::ordered_json figures;
  port.add_figures(figures);
  EXPECT_EQ(figures["queue_full"], 1);
}

TEST(TcpServerPort, RefusesAnAddressThatIsTaken) {
  TcpServerPort port(InetAddress::loopback(0));
  const std::string endpoint = port.endpoint();
  const auto number =
      static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
  EXPECT_THROW(TcpServerPort(InetAddress::loopback(number)), std::system_error);
}

/// A port whose connection the test makes and breaks.
class SwitchedPort final : public HilPort {
 public:
  bool send(std::span<const std::uint8_t>) override { return is_connected; }
  void poll(const OnBytes& on_bytes) override {
    for (const auto& bytes : in) on_bytes(bytes, {});
    in.clear();
  }
  bool wait(base::Duration) override { return !in.empty(); }
  base::RunTime now() const override { return {}; }
  std::uint64_t peers() const override { return count; }
  bool connected() const override { return is_connected; }
  std::string endpoint() const override { return "test"; }
  void connect() {
    ++count;
    is_connected = true;
  }
  void answer(std::uint64_t time_usec) {
    const auto bytes = encoder(mv::HilActuatorControls{.time_usec = time_usec});
    in.emplace_back(bytes.begin(), bytes.end());
  }

  std::uint64_t count = 0;
  bool is_connected = false;
  mav::Encoder encoder{{1, 1}};
  std::vector<std::vector<std::uint8_t>> in;
};

class JoinsByAnswering : public testing::Test {
 protected:
  void sample(int ms) {
    ImuSample imu{.time = base::SimTime(std::chrono::milliseconds(ms))};
    interface_.on_imu(imu);
    interface_.flush(imu.time);
  }
  void answer(std::uint64_t time_usec) {
    port_.answer(time_usec);
    interface_.receive();
  }

  SwitchedPort port_;
  HilInterface interface_{{.scales = {},
                           .actuator_timeout = std::chrono::milliseconds(500),
                           .joins_by_answering = true},
                          port_,
                          nullptr};
};

TEST_F(JoinsByAnswering, IsWaitedForFromItsFirstAnswerOn) {
  port_.connect();
  sample(4);
  sample(8);
  EXPECT_FALSE(interface_.in_step());
  answer(4000);
  EXPECT_TRUE(interface_.in_step());
  EXPECT_TRUE(interface_.answered()) << "what came before is not asked for";
  sample(12);
  EXPECT_FALSE(interface_.answered());
  answer(12000);
  EXPECT_TRUE(interface_.answered());
}

TEST_F(JoinsByAnswering, AClockOfItsOwnIsNoAnswer) {
  port_.connect();
  sample(4);
  answer(3999);
  EXPECT_FALSE(interface_.in_step()) << "a build without lockstep flies in real time";
}

TEST_F(JoinsByAnswering, OneThatHasGoneIsNotWaitedForAndANewOneJoinsAnew) {
  port_.connect();
  sample(4);
  answer(4000);
  sample(8);
  port_.is_connected = false;
  interface_.receive();
  EXPECT_FALSE(interface_.in_step());
  port_.connect();
  sample(12);
  EXPECT_FALSE(interface_.in_step());
  EXPECT_EQ(interface_.sent().of(mv::Heartbeat::kId), 2U) << "each is greeted";
  answer(12000);
  EXPECT_TRUE(interface_.in_step());
}

TEST_F(JoinsByAnswering, AnAnswerToWhatTheLastOneWasSentIsNone) {
  port_.connect();
  sample(4);
  port_.is_connected = false;
  port_.connect();
  interface_.receive();
  answer(4000);
  EXPECT_FALSE(interface_.in_step());
}

}  // namespace
}  // namespace cas::sim

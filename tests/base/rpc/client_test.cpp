// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/client.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/base/rpc/running_server.hpp"
#include "tests/support/refusal.hpp"

namespace cas::base::rpc {
namespace {

using namespace std::chrono_literals;
using cas::test::thrown;

/// A server's side by hand: listens, accepts one client, sends any bytes.
class FakeServer {
 public:
  FakeServer() : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_, 4), 0);
    socklen_t size = sizeof address;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  ~FakeServer() {
    hang_up();
    ::close(listener_);
  }
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  const std::string& address() const { return address_; }
  void accept() { peer_ = ::accept(listener_, nullptr, nullptr); }
  void send(const std::string& bytes) { ::send(peer_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void hang_up() {
    if (peer_ >= 0) ::close(std::exchange(peer_, -1));
  }

 private:
  int listener_;
  int peer_ = -1;
  std::string address_;
};

TEST(Client, ReturnsTheResult) {
  RunningServer server;
  Client client(server.address());
  EXPECT_EQ(client.call("echo", {{"a", 1}}, kPatience), (Json{{"a", 1}}));
  EXPECT_TRUE(client.call("echo", nullptr, kPatience).is_null());
}

TEST(Client, ThrowsTheServersError) {
  RunningServer server;
  Client client(server.address());
  const auto error = thrown<CallError>([&] { client.call("fail", nullptr, kPatience); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code(), kRefused);
  EXPECT_STREQ(error->what(), "refused");
  EXPECT_EQ(error->data_json(), R"({"result":4})");
  EXPECT_EQ(client.call("echo", {2}, kPatience), Json({2}));
}

TEST(Client, AnAnswerThatDoesNotComeIsATimeout) {
  RunningServer server;
  Client client(server.address());
  const auto error = thrown<ConnectionError>([&] { client.call("keep", nullptr, 20ms); });
  EXPECT_TRUE(error.value().timeout());
  server.answer_kept();  // late: no call waits for it
  EXPECT_EQ(client.call("echo", {3}, kPatience), Json({3}));
}

TEST(Client, NotificationsWaitWhileACallIsUnderWay) {
  RunningServer server;
  Client client(server.address());
  client.call("subscribe", {{"topic", "status"}}, kPatience);
  for (int i = 0; i < 3; ++i) server.publish("status", {{"i", i}});
  EXPECT_EQ(client.call("echo", {4}, kPatience), Json({4}));
  std::string method;
  Json params;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(client.next_notification(method, params, kPatience));
    EXPECT_EQ(method, "status");
    EXPECT_EQ(params["i"], i);
  }
  EXPECT_FALSE(client.next_notification(method, params, 10ms));
}

TEST(Client, LargeAnswersArriveWhole) {
  RunningServer server;
  Client client(server.address());
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(client.call("big", nullptr, kPatience).get<std::string>().size(), 100'000U);
  }
}

TEST(Client, MovesWithItsConnection) {
  RunningServer server;
  Client first(server.address());
  Client second(std::move(first));
  EXPECT_EQ(second.call("echo", {5}, kPatience), Json({5}));
}

TEST(Client, NobodyListeningIsNoTimeout) {
  std::string address;
  {
    const FakeServer gone;
    address = gone.address();
  }
  const auto error = thrown<ConnectionError>([&] { Client client(address); });
  EXPECT_FALSE(error.value().timeout());
  EXPECT_NE(std::string(error->what()).find(address), std::string::npos);
}

TEST(Client, AddressesThatAreNoneAreRefused) {
  for (const char* address : {"", "localhost", ":5790", "localhost:", "unix:", "127.0.0.1:port",
                              "unix:/nowhere/socket"}) {
    EXPECT_THROW(Client client(address), ConnectionError) << address;
  }
}

TEST(Client, AServerThatHangsUpIsNoTimeout) {
  FakeServer server;
  Client client(server.address());
  server.accept();
  server.hang_up();
  const auto call = [&] { client.call("echo", {1}, kPatience); };
  EXPECT_FALSE(thrown<ConnectionError>(call).value().timeout());
  EXPECT_THROW(call(), ConnectionError);  // and stays so
}

TEST(Client, AServerOfAnotherProtocolIsTold) {
  FakeServer server;
  Client client(server.address());
  server.accept();
  server.send("HTTP/1.1 400 Bad Request\r\n");
  EXPECT_THROW(client.call("echo", {1}, kPatience), ConnectionError);
}

TEST(Client, AnErrorWithoutAnIdEndsTheCall) {
  FakeServer server;
  Client client(server.address());
  server.accept();
  server.send(R"({"jsonrpc":"2.0","id":null,"error":{"code":-32603,"message":"full"}})"
              "\n");
  EXPECT_EQ(cas::test::refusal<CallError>([&] { client.call("echo", {1}, kPatience); }), "full");
}

TEST(Client, AMalformedErrorIsStillAnError) {
  FakeServer server;
  Client client(server.address());
  server.accept();
  server.send(R"({"jsonrpc":"2.0","id":1,"error":"no"})"
              "\n");
  EXPECT_THROW(client.call("echo", {1}, kPatience), CallError);
}

}  // namespace
}  // namespace cas::base::rpc

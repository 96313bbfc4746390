// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "base/error.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/base/rpc/running_server.hpp"
#include "tests/support/refusal.hpp"

namespace cas::base::rpc {
namespace {

constexpr const char* kEcho = R"({"jsonrpc":"2.0","id":1,"method":"echo","params":[1]})";
constexpr const char* kKeep = R"({"jsonrpc":"2.0","id":2,"method":"keep"})";
constexpr const char* kSubscribe =
    R"({"jsonrpc":"2.0","id":3,"method":"subscribe","params":{"topic":"status"}})";

struct ServedClient : testing::Test {
  RunningServer server;
  RawClient client{server.port()};
};

TEST_F(ServedClient, AnswersALine) { EXPECT_EQ(client.ask(kEcho)["result"], Json({1})); }

TEST_F(ServedClient, ALineMayComeInPieces) {
  for (const char c : std::string(kEcho) + "\r\n") client.send(std::string(1, c));
  EXPECT_EQ(client.json()["result"], Json({1}));
}

TEST_F(ServedClient, ManyLinesMayComeInOnePiece) {
  std::string lines;
  for (int i = 0; i < 200; ++i) {
    lines += R"({"jsonrpc":"2.0","method":"echo","id":)" + std::to_string(i) + "}\n";
  }
  EXPECT_TRUE(client.send(lines));
  for (int i = 0; i < 200; ++i) EXPECT_EQ(client.json()["id"], i);
}

// It uses another protocol: no later data is meant for this server.
TEST(Server, EndsAConnectionAtALineThatIsNoRequest) {
  RunningServer server;
  for (const char* line : {"nonsense", "{\"jsonrpc\":", "42", "[]", "{}",
                           R"({"jsonrpc":"1.0","id":1,"method":"echo"})"}) {
    RawClient client(server.port());
    client.send(std::string(line) + "\n" + kKeep + "\n");
    const int code = client.json()["error"]["code"];
    EXPECT_TRUE(code == kParseError || code == kInvalidRequest) << line;
    EXPECT_EQ(client.line(), std::nullopt) << line;
    EXPECT_TRUE(client.closed_by_server()) << line;
  }
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNotJsonRpc, 6));
  EXPECT_EQ(server.kept(), 0U);
}

TEST_F(ServedClient, EndsAConnectionAfterABatchThatHoldsNoRequest) {
  client.send("[" + std::string(kEcho) + ",7]\n" + kKeep + "\n");
  const Json answers = client.json();
  EXPECT_EQ(answers.at(0)["result"], Json({1}));
  EXPECT_EQ(answers.at(1)["error"]["code"], kInvalidRequest);
  EXPECT_TRUE(client.closed_by_server());
  EXPECT_EQ(server.kept(), 0U);
}

TEST_F(ServedClient, GoesOnAfterACallThatFailsAndABlankLine) {
  for (const char* line : {R"({"jsonrpc":"2.0","id":4,"method":"none"})",
                           R"({"jsonrpc":"2.0","id":4,"method":"subscribe","params":{}})",
                           R"({"jsonrpc":"2.0","id":4,"method":"fail"})",
                           R"({"jsonrpc":"2.0","id":4,"method":"throw"})"}) {
    EXPECT_TRUE(client.ask(line).contains("error")) << line;
  }
  client.send("\r\n \n");
  EXPECT_EQ(client.ask(kEcho)["result"], Json({1}));
}

TEST_F(ServedClient, ALateAnswerDoesNotHoldUpTheNext) {
  client.send(std::string(kKeep) + "\n");
  EXPECT_EQ(client.ask(kEcho)["id"], 1);
  server.answer_kept();
  EXPECT_EQ(client.json()["id"], 2);
}

TEST_F(ServedClient, AnswersAfterTheClientsEndOfInput) {
  client.send(std::string(kKeep) + "\n" + kEcho);  // the last line lacks its newline
  client.end_of_input();
  EXPECT_EQ(client.json()["id"], 1);
  EXPECT_TRUE(server.wait_for_kept(1));
  server.answer_kept();
  EXPECT_EQ(client.json()["id"], 2);
  EXPECT_TRUE(client.closed_by_server());
  EXPECT_TRUE(server.wait_for_clients(0));
}

TEST(Server, AnAnswerToAClientThatLeftIsHarmless) {
  RunningServer server;
  {
    RawClient client(server.port());
    client.send(std::string(kKeep) + "\n");
    EXPECT_TRUE(server.wait_for_kept(1));
  }
  server.answer_kept();
  EXPECT_TRUE(server.wait_for_clients(0));
  EXPECT_EQ(RawClient(server.port()).ask(kEcho)["id"], 1);
}

TEST(Server, OnlySubscribersGetNotifications) {
  RunningServer server;
  RawClient subscriber(server.port());
  RawClient other(server.port());
  EXPECT_EQ(subscriber.ask(kSubscribe)["result"], true);
  EXPECT_EQ(other.ask(kEcho)["id"], 1);
  server.publish("status", {{"rate_hz", 500}});
  server.publish("unknown", {});
  const Json notification = subscriber.json();
  EXPECT_EQ(notification["method"], "status");
  EXPECT_EQ(notification["params"]["rate_hz"], 500);
  EXPECT_FALSE(notification.contains("id"));
  EXPECT_EQ(other.ask(kEcho)["id"], 1);  // nothing came before it
}

TEST_F(ServedClient, ClosingEndsAllConnections) {
  EXPECT_EQ(client.ask(kEcho)["id"], 1);
  client.send(std::string(kKeep) + "\n");
  EXPECT_TRUE(server.wait_for_kept(1));
  server.run([&] { server.server().close(); });
  EXPECT_TRUE(client.closed_by_server());
  server.answer_kept();  // its client has left
}

TEST_F(ServedClient, AMethodMayCloseTheServer) {
  client.send("{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"close\"}\n" + std::string(kEcho) + "\n");
  EXPECT_TRUE(client.closed_by_server());
}

TEST(Server, APortInUseIsAConfigError) {
  RunningServer server;
  boost::asio::io_context io;
  Server second(io);
  const std::string said = test::refusal([&] { second.listen_tcp("127.0.0.1", server.port()); });
  EXPECT_NE(said.find(std::to_string(server.port())), std::string::npos) << said;
}

TEST(Server, AnAddressThatIsNoneIsAConfigError) {
  boost::asio::io_context io;
  Server server(io);
  EXPECT_THROW(server.listen_tcp("300.1.1.1", 0), ConfigError);
  EXPECT_THROW(server.listen_tcp("192.0.2.1", 0), ConfigError);  // no address of this host
}

TEST(Server, ListensOnIpv6) {
  RunningServer server;
  std::uint16_t port = 0;
  try {
    port = server.run([&] { return server.server().listen_tcp("::1", 0); });
  } catch (const ConfigError&) {
    GTEST_SKIP() << "this machine has no IPv6";
  }
  EXPECT_GT(port, 0);
}

// A child process must inherit none of them.
TEST_F(ServedClient, EverySocketIsClosedOnExec) {
  EXPECT_EQ(client.ask(kEcho)["id"], 1);
  int sockets = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    const auto target = std::filesystem::read_symlink(entry.path(), error).string();
    if (error || !target.starts_with("socket:")) continue;
    const int fd = std::stoi(entry.path().filename());
    if (fd <= 2) continue;
    ++sockets;
    EXPECT_NE(::fcntl(fd, F_GETFD) & FD_CLOEXEC, 0) << target;
  }
  EXPECT_GE(sockets, 3);  // listener, accepted, client
}

}  // namespace
}  // namespace cas::base::rpc

// SPDX-License-Identifier: BSD-3-Clause
// Clients that are slow, endless, many or gone: each pays alone.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/rpc/server.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/base/rpc/running_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base::rpc {
namespace {

constexpr const char* kKeepCall = R"({"jsonrpc":"2.0","id":2,"method":"keep"})";
constexpr const char* kEchoCall = R"({"jsonrpc":"2.0","id":1,"method":"echo","params":[1]})";

TEST(ServerAbuse, AnEndlessLineIsAnsweredAndEnded) {
  RunningServer server;
  RawClient client(server.port());
  client.send(std::string(70 * 1024, 'x'));
  EXPECT_EQ(client.json()["error"]["code"], kParseError);
  EXPECT_TRUE(client.closed_by_server());
  EXPECT_TRUE(server.wait_for_clients(0));
}

TEST(ServerAbuse, ALineOfTheLargestSizeIsServed) {
  RunningServer server(ServerLimits{.max_line_bytes = 1024});
  RawClient client(server.port());
  std::string line = R"({"jsonrpc":"2.0","id":1,"method":"echo","params":[")";
  line += std::string(1024 - line.size() - 4, 'x') + "\"]}";
  EXPECT_EQ(client.ask(line)["id"], 1);
  client.send(line + " \n");
  EXPECT_EQ(client.json()["error"]["code"], kParseError);
}

TEST(ServerAbuse, AClientThatNeverReadsIsClosedAndOthersAreServed) {
  RunningServer server;
  RawClient greedy(server.port());
  RawClient other(server.port());
  const std::string request = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"big\"}\n";
  bool open = true;
  for (int i = 0; open && i < 100'000; ++i) {
    open = greedy.send(request);
    if (i % 100 == 0) {
      EXPECT_EQ(other.ask(kEchoCall)["id"], 1);
    }
  }
  EXPECT_FALSE(open) << "10 GB of answers were kept";
  EXPECT_TRUE(server.wait_for_clients(1));
  EXPECT_EQ(other.ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, AnAnswerThatIsTooLongLeavesTheConnectionOpen) {
  RunningServer server(ServerLimits{.max_queued_bytes = 50'000});
  RawClient client(server.port());
  const Json answer = client.ask(R"({"jsonrpc":"2.0","id":7,"method":"big"})");
  EXPECT_EQ(answer["id"], 7);
  EXPECT_EQ(answer["error"]["code"], kInternalError);
  EXPECT_EQ(client.ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, UnfinishedBatchesOfAClientThatLeavesLeaveNothing) {
  RunningServer server;
  const std::string batch = "[" + std::string(kKeepCall) + "," + std::string(kEchoCall) + "]\n";
  {
    RawClient client(server.port());
    client.send(batch);
    EXPECT_TRUE(server.wait_for_kept(1));
  }
  server.answer_kept();
  EXPECT_TRUE(server.wait_for_clients(0));
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, ASubscriberThatNeverReadsIsClosedAndOthersAreServed) {
  RunningServer server;
  RawClient lazy(server.port());
  RawClient reader(server.port());
  const std::string subscribe =
      R"({"jsonrpc":"2.0","id":3,"method":"subscribe","params":{"topic":"status"}})";
  EXPECT_EQ(lazy.ask(subscribe)["result"], true);
  EXPECT_EQ(reader.ask(subscribe)["result"], true);
  const Json params{{"text", std::string(100'000, 'x')}};
  int published = 0;
  while (published < 10'000 && server.run([&] { return server.server().clients(); }) == 2) {
    server.publish("status", params);
    ++published;
    EXPECT_EQ(reader.json()["method"], "status");
  }
  EXPECT_LT(published, 10'000);
  EXPECT_EQ(reader.ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, AThousandQuickClientsAreAllServed) {
  RunningServer server;
  for (int i = 0; i < 1000; ++i) {
    Client client(server.address(), kPatience);
    EXPECT_EQ(client.call("echo", {i}, kPatience), Json({i}));
    // The server notices an end later than the client: at most the limit are open at once.
    if (i % 50 == 49) {
      client = Client(server.address(), kPatience);
      EXPECT_TRUE(server.wait_until([](Server& s) { return s.clients() <= 1; }));
    }
  }
  EXPECT_TRUE(server.wait_for_clients(0));
}

TEST(ServerAbuse, AThousandClientsThatLeaveAtOnceLeaveNothingBehind) {
  RunningServer server;
  for (int i = 0; i < 1000; ++i) {
    RawClient client(server.port());
    if (i % 3 == 0) client.send(std::string(kEchoCall) + "\n");
    if (i % 3 == 1) client.send("half a line");
  }
  EXPECT_TRUE(server.wait_for_clients(0));
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, AClientBeyondItsShareIsToldAndClosed) {
  RunningServer server(ServerLimits{.max_clients = 4});
  std::vector<RawClient> clients;
  for (const char* from : {"127.0.0.1", "127.0.0.2"}) {
    clients.emplace_back(server.port(), from);
    EXPECT_EQ(clients.back().ask(kEchoCall)["id"], 1);
  }
  RawClient third(server.port(), "127.0.0.3");  // all of loopback is one address
  third.send(std::string(kEchoCall) + "\n");
  const Json refusal = third.json();
  EXPECT_TRUE(refusal["id"].is_null());
  EXPECT_EQ(refusal["error"]["code"], kInternalError);
  EXPECT_TRUE(third.closed_by_server());
  third.close();
  clients.pop_back();
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNoPlace, 1));
  EXPECT_TRUE(server.wait_for_clients(1));
  EXPECT_EQ(RawClient(server.port(), "127.0.0.2").ask(kEchoCall)["id"], 1);
}

/// A server that listens on a Unix socket too.
class UnixAbuse : public testing::Test {
 protected:
  void start(const ServerLimits& limits = {}) {
    server_.emplace(limits);
    server_->run([&] { server_->server().listen_unix(path_); });
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_.path() / "rpc";
  std::optional<RunningServer> server_;
};

TEST_F(UnixAbuse, SilentClientsEverywhereLeaveAPlaceForTheOwner) {
  start();
  std::vector<RawClient> silent;
  for (int i = 0; i < 40; ++i) silent.emplace_back(server_->port());
  for (int i = 0; i < 64; ++i) silent.emplace_back(path_);
  EXPECT_TRUE(server_->wait_for_clients(64));
  Client owner("unix:" + path_);
  EXPECT_EQ(owner.call("echo", {1}, kPatience), Json({1}));
  EXPECT_TRUE(server_->wait_for_clients(64)) << "one silent client has gone for it";
}

TEST(ServerAbuse, SilentClientsOfOneAddressLockNobodyOut) {
  RunningServer server;
  RawClient served(server.port());
  EXPECT_EQ(served.ask(kEchoCall)["id"], 1);
  std::vector<RawClient> silent;
  for (int i = 0; i < 200; ++i) silent.emplace_back(server.port());
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
  EXPECT_EQ(served.ask(kEchoCall)["id"], 1) << "who has asked keeps its place";
}

TEST(ServerAbuse, ClientsThatHaveLeftAgainKeepNobodyWaiting) {
  RunningServer server(ServerLimits{.max_accepts_s = 20});
  EXPECT_EQ(server.run([&server] {  // none is accepted meanwhile
    for (int i = 0; i < 1000; ++i) RawClient(server.port()).close();
    return 0;
  }),
            0);
  const RunTime start = steady_now();
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
  EXPECT_LT(steady_now() - start, std::chrono::seconds(20)) << "1000 at 20 a second take 50 s";
}

TEST_F(UnixAbuse, ClientsThatHaveAskedKeepTheirPlaces) {
  start(ServerLimits{.max_clients = 4});
  std::vector<RawClient> served;
  for (int i = 0; i < 4; ++i) {
    served.emplace_back(path_);
    EXPECT_EQ(served.back().ask(kEchoCall)["id"], 1);
  }
  RawClient fifth(path_);
  EXPECT_EQ(fifth.json()["error"]["code"], kInternalError);
  EXPECT_TRUE(fifth.closed_by_server());
  for (RawClient& client : served) EXPECT_EQ(client.ask(kEchoCall)["id"], 1);
}

TEST_F(UnixAbuse, SilentClientsLoseTheirPlaces) {
  start(ServerLimits{.first_request_time = std::chrono::seconds(1)});
  std::vector<RawClient> silent;
  for (int i = 0; i < 8; ++i) silent.emplace_back(path_);
  for (RawClient& client : silent) {
    EXPECT_TRUE(client.json()["id"].is_null());
    EXPECT_TRUE(client.closed_by_server());
    client.close();
  }
  EXPECT_TRUE(server_->wait_for_refused(Refusal::kNoRequest, 8));
}

// Refused clients take no places while they get the reason.
TEST_F(UnixAbuse, ACrowdOfOneAddressLeavesTheOtherPlaces) {
  start();
  std::vector<RawClient> crowd;
  for (int i = 0; i < 300; ++i) crowd.emplace_back(server_->port());
  EXPECT_TRUE(server_->wait_until([](Server& each) { return each.clients() >= 32; }));
  std::vector<RawClient> others;
  for (int i = 0; i < 32; ++i) {
    others.emplace_back(path_);
    EXPECT_EQ(others.back().ask(kEchoCall)["id"], 1);
  }
  EXPECT_EQ(server_->run([&] { return server_->server().clients(); }), 64U);
}

TEST(ServerAbuse, SilentTcpClientsLoseTheirPlaces) {
  RunningServer server(ServerLimits{.first_request_time = std::chrono::seconds(1)});
  std::vector<RawClient> silent;
  for (int i = 0; i < 32; ++i) silent.emplace_back(server.port());
  silent[0].send("\n\n");  // blank lines are no request
  silent[1].send("\x16\x03\x01\x02 the first bytes of TLS, without a newline");
  for (RawClient& client : silent) {
    EXPECT_TRUE(client.json()["id"].is_null());
    EXPECT_TRUE(client.closed_by_server());
    client.close();
  }
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNoRequest, 32));
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
}

// Data in flight while the server closes a connection is dropped.
TEST(ServerAbuse, AClientThatSendsAfterItsRefusalHarmsNobody) {
  RunningServer server(ServerLimits{.first_request_time = std::chrono::seconds(1)});
  RawClient late(server.port());
  late.send("begun, not ended");
  EXPECT_TRUE(late.json()["id"].is_null());
  for (int i = 0; i < 20; ++i) late.send(std::string(512, 'x'));
  late.send(std::string(kEchoCall) + "\n");
  EXPECT_EQ(late.line(), std::nullopt) << "nothing is called any more";
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNoRequest, 1));
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, AClientMayBeSilentAfterItsFirstRequest) {
  RunningServer server(ServerLimits{.first_request_time = std::chrono::seconds(1)});
  RawClient watcher(server.port());
  EXPECT_EQ(watcher.ask(kEchoCall)["id"], 1);
  RawClient silent(server.port());  // its end proves that the time is over for the watcher too
  EXPECT_TRUE(silent.closed_by_server());
  EXPECT_EQ(watcher.ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, ARequestInTheBodyOfAWebPageIsNotCalled) {
  RunningServer server;
  RawClient browser(server.port());
  const std::string body = std::string(kKeepCall) + "\n";
  EXPECT_TRUE(browser.send("POST / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server.port()) +
                           "\r\nUser-Agent: curl/7.88.1\r\nAccept: */*\r\nContent-Length: " +
                           std::to_string(body.size()) +
                           "\r\nContent-Type: application/x-www-form-urlencoded\r\n\r\n" + body));
  EXPECT_EQ(browser.json()["error"]["code"], kParseError);
  EXPECT_EQ(browser.line(), std::nullopt) << "one answer, then the end";
  EXPECT_TRUE(browser.closed_by_server());
  browser.close();
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNotJsonRpc, 1));
  EXPECT_EQ(server.kept(), 0U);
}

TEST(ServerAbuse, CurlCallsNothing) {
  const std::string curl = "/usr/bin/curl";
  if (::access(curl.c_str(), X_OK) != 0) GTEST_SKIP() << curl << " is not installed";
  RunningServer server;
  const std::string command = curl + " --silent --noproxy '*' --max-time 20 --data-binary '" +
                              kKeepCall + "\n' http://" + server.address() + "/ >/dev/null 2>&1";
  EXPECT_NE(std::system(command.c_str()), 0) << "an answer that is not HTTP";
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNotJsonRpc, 1));
  EXPECT_TRUE(server.wait_for_clients(0));
  EXPECT_EQ(server.kept(), 0U);
}

TEST(ServerAbuse, ABurstOfConnectionsLeavesTheServerWhole) {
  RunningServer server;
  {
    std::vector<RawClient> burst;
    for (int i = 0; i < 300; ++i) burst.emplace_back(server.port());
  }
  EXPECT_TRUE(server.wait_for_clients(0));
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, WithoutDescriptorsClientsWaitAndAreServedLater) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "UBSan opens a pipe to check an object's type and reports a fault without one";
#endif
  RunningServer server;
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  RawClient client(server.port());
  EXPECT_EQ(client.ask(kEchoCall)["id"], 1);
  const RawClient probe(server.port());
  EXPECT_TRUE(server.wait_for_clients(2));
  const int lowest_free = ::dup(0);
  ::close(lowest_free);
  rlimit tight = before;
  tight.rlim_cur = static_cast<rlim_t>(lowest_free) + 1;
  ::setrlimit(RLIMIT_NOFILE, &tight);
  RawClient late(server.port());  // takes the last one; accepting needs one more
  EXPECT_EQ(client.ask(kEchoCall)["id"], 1);
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(late.ask(kEchoCall)["id"], 1);
}

TEST(ServerAbuse, AClientThatAsksTooFastIsSlowedDownAndOthersAreNot) {
  RunningServer server(ServerLimits{.max_lines_s = 50});
  RawClient hasty(server.port());
  const base::RunTime start = base::steady_now();
  std::string flood;
  for (int i = 0; i < 70; ++i)
    flood += R"({"jsonrpc":"2.0","id":1,"method":"echo"})"
             "\n";
  ASSERT_TRUE(hasty.send(flood));
  RawClient patient(server.port());
  EXPECT_TRUE(patient.ask(R"({"jsonrpc":"2.0","id":1,"method":"echo"})").contains("result"));
  for (int i = 0; i < 70; ++i) EXPECT_TRUE(hasty.json().contains("result"));
  // 50 at once, the other 20 at 50 a second.
  EXPECT_GE(base::steady_now() - start, std::chrono::milliseconds(350));
}

TEST(ServerAbuse, RandomBytesNeverEndTheServer) {
  RunningServer server;
  std::mt19937 random(1);  // fixed: the same bytes in every run
  const std::string alphabet = "{}[]\":,0123456789.eE+-truefalsn\\u jsonrpc methodid\n\n\n\x80\xff";
  std::uniform_int_distribution<std::size_t> letter(0, alphabet.size() - 1);
  for (int round = 0; round < 500; ++round) {  // the first line that is no request is the last
    RawClient client(server.port());
    std::string bytes;
    for (int i = 0; i < 200; ++i) bytes += alphabet[letter(random)];
    client.send(bytes);
    client.end_of_input();
    EXPECT_TRUE(client.closed_by_server());
  }
  EXPECT_EQ(RawClient(server.port()).ask(kEchoCall)["id"], 1);
}

}  // namespace
}  // namespace cas::base::rpc

// SPDX-License-Identifier: BSD-3-Clause
// Access to the command port of the real casd, and casctl's search for it.
#include <gmock/gmock.h>
#include <grp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/rpc/token.hpp"
#include "mavlink_gen/runtime/signing.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;
using base::rpc::Client;
using base::rpc::RawClient;
using nlohmann::json;

constexpr const char* kStatus = R"({"jsonrpc":"2.0","id":1,"method":"casd.status"})";
constexpr const char* kLinks = "links:\n  - {name: a, type: udp, local: '127.0.0.1:0'}\n";

/// casd and casctl in a session of their own, with a runtime folder of their own.
class CommandPort : public testing::Test {
 protected:
  static std::vector<std::string> in_session(const fs::path& session, const std::string& program,
                                             const std::vector<std::string>& arguments) {
    std::vector<std::string> command{"/usr/bin/env",
                                     "-u",
                                     "CASD_ADDRESS",
                                     "-u",
                                     "CASD_TOKEN_FILE",
                                     "-u",
                                     "STATE_DIRECTORY",
                                     "CAS_RUNTIME_DIR=" + (session / "cas").string(),
                                     binary_dir() + "/bin/" + program};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return command;
  }
  /// @param port  the block `command_port`; "$DIR" is the test's folder
  fs::path topology(std::string port, const std::string& links = kLinks) const {
    for (auto at = port.find("$DIR"); at != std::string::npos; at = port.find("$DIR")) {
      port.replace(at, 4, folder_.path().string());
    }
    return folder_.write("casd.yaml", "schema: 1\ncommand_port: " + port + "\n" + links);
  }
  std::unique_ptr<ChildProcess> launch(const std::string& port,
                                       const std::string& links = kLinks) const {
    return std::make_unique<ChildProcess>(
        in_session(session_.path(), "casd", {topology(port, links).string()}));
  }
  /// Starts casd and waits until it is ready.
  void start(const std::string& port, const std::string& links = kLinks) {
    casd_ = launch(port, links);
    const std::optional<std::string> status = casd_->wait_ready();
    ASSERT_TRUE(status.has_value()) << casd_->output();
    status_ = *status + " ";
    tcp_ = word("command_port");
  }
  void stop() {
    casd_->signal(SIGTERM);
    ASSERT_EQ(casd_->wait_exit(), 0) << casd_->output();
  }
  std::string word(const std::string& key) const {
    const std::size_t at = status_.find(key + " ");
    if (at == std::string::npos) return "";
    const std::size_t begin = at + key.size() + 1;
    return status_.substr(begin, status_.find(' ', begin) - begin);
  }
  std::uint16_t port() const { return port_of(tcp_); }
  /// Waits for a link, which on a busy machine may open after casd is ready. @return its port; 0:
  /// it did not open
  std::uint16_t link_port(const std::string& name) const {
    Client client("unix:" + word("command_socket"));
    std::uint16_t port = 0;
    wait_until([&] {
      for (const json& link : client.call("link.list", json::object())) {
        const auto endpoint = link.value("endpoint", "");
        if (link["name"] == name && link["state"] == "up") port = port_of(endpoint);
      }
      return port != 0;
    });
    return port;
  }
  /// casd does not start: its exit code and that it says `why`.
  void expect_refused(const std::string& port, const std::string& why) const {
    const auto casd = launch(port);
    EXPECT_EQ(casd->wait_exit(), 71) << casd->output();
    EXPECT_THAT(casd->output(), HasSubstr(why));
  }
  Ended casctl(const std::vector<std::string>& arguments) const {
    return ChildProcess(in_session(session_.path(), "casctl", arguments)).end();
  }
  fs::path runtime() const { return session_.path() / "cas"; }
  /// Socket files in the runtime folder.
  std::vector<fs::path> sockets() const {
    std::vector<fs::path> found;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(runtime(), none)) {
      if (entry.is_socket()) found.push_back(entry.path());
    }
    return found;
  }

  TemporaryFolder folder_;
  TemporaryFolder session_;
  std::unique_ptr<ChildProcess> casd_;
  std::string status_;
  std::string tcp_;
};

TEST_F(CommandPort, HasASocketAndATokenOfItsOwn) {
  const std::string fixed = std::to_string(free_port());
  start("{port: " + fixed + "}");
  const fs::path socket = runtime() / ("casd-" + fixed + ".sock");
  EXPECT_EQ(word("command_socket"), socket.string());
  struct stat status {};
  ASSERT_EQ(::lstat(socket.c_str(), &status), 0);
  EXPECT_TRUE(S_ISSOCK(status.st_mode));
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  ASSERT_EQ(::lstat((runtime() / "casd.token").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);

  EXPECT_EQ(Client("unix:" + socket.string()).call("casd.status", json::object())["program"],
            "casd");
  EXPECT_EQ(RawClient(port()).ask(kStatus)["error"]["code"], base::rpc::kNotAuthorised);
  Client remote(tcp_);
  remote.call("authorise", {{"token", base::rpc::read_token(runtime() / "casd.token")}});
  EXPECT_EQ(remote.call("casd.status", json::object())["program"], "casd");

  casd_->signal(SIGTERM);
  EXPECT_EQ(casd_->wait_exit(), 0);
  EXPECT_FALSE(fs::exists(socket));
  EXPECT_TRUE(fs::exists(runtime() / "casd.token")) << "scripts hold on to it";
}

TEST_F(CommandPort, CasctlTakesTheSocketFirst) {
  start("{port: 0, unix: " + (runtime() / "casd.sock").string() + "}");
  EXPECT_EQ(casctl({"reload"}).code, 0);
  EXPECT_TRUE(wait_until([&] {
    return casd_->output().find("audit: unix:uid " + std::to_string(::geteuid()) +
                                " casd.reload: done") != std::string::npos;
  })) << casd_->output();
}

TEST_F(CommandPort, CasctlFindsACasdThatTookAFreePort) {
  start("{port: 0}");
  EXPECT_EQ(word("command_socket"),
            (runtime() / ("casd-" + std::to_string(port()) + ".sock")).string());
  EXPECT_EQ(casctl({"status"}).code, 0);

  casd_->signal(SIGKILL);
  ASSERT_TRUE(casd_->wait_exit().has_value());
  ASSERT_EQ(sockets().size(), 1U) << "nobody removed it";
  // In its place casctl asks at the usual port, where somebody's own casd may run.
  if (!TcpPeer(5790).connected()) {
    EXPECT_EQ(casctl({"status"}).code, 3) << "nobody listens there";
  }
  start("{port: 0}");
  EXPECT_EQ(sockets(), std::vector<fs::path>{word("command_socket")});
  EXPECT_EQ(casctl({"status"}).code, 0);
}

TEST_F(CommandPort, CasctlFindsACasdWithASocketElsewhere) {
  start("{port: 0, unix: $DIR/casd.sock}");
  EXPECT_EQ(word("command_socket"), (folder_ / "casd.sock").string());
  ASSERT_EQ(sockets().size(), 1U);
  struct stat status {};
  ASSERT_EQ(::lstat(sockets().front().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  EXPECT_EQ(casctl({"status"}).code, 0);

  stop();
  start("{port: 0, unix: " + (runtime() / "casd-mine.sock").string() + "}");
  EXPECT_EQ(sockets(), std::vector<fs::path>{runtime() / "casd-mine.sock"}) << "it is there";
  stop();
  start("{port: 0, unix: none}");
  EXPECT_TRUE(sockets().empty());
}

TEST_F(CommandPort, ACasdWithoutARuntimeFolderRuns) {
  fs::create_symlink(folder_ / "elsewhere", runtime());
  start("{port: 0, unix: $DIR/casd.sock, token_file: $DIR/secret}");
  EXPECT_THAT(casd_->output(), HasSubstr("casctl finds this casd by its address alone: "));
  EXPECT_EQ(casctl({"--address", "unix:" + (folder_ / "casd.sock").string(), "status"}).code, 0);
}

TEST_F(CommandPort, CasctlListsSeveralCasds) {
  UdpPeer vehicle;
  start("{port: 0}", "links:\n  - {name: fcu, type: udp, local: '127.0.0.1:0', remote: '" +
                         vehicle.endpoint() + "'}\n");
  const std::string first = "unix:" + word("command_socket");
  Client client(first);
  vehicle.set_remote(link_port("fcu"));
  mav::Encoder encode({7, 1});
  mavlink::common::Heartbeat heartbeat;
  heartbeat.autopilot = mavlink::common::MavAutopilot::kPx4;
  ASSERT_TRUE(wait_until([&] {
    vehicle.send(encode(heartbeat));
    return !client.call("casd.status", json::object())["vehicles"].empty();
  }));
  const fs::path second = folder_.write(
      "bench two.yaml", std::string("schema: 1\n") + "command_port: {port: 0}\n" + kLinks);
  ChildProcess other(in_session(session_.path(), "casd", {second.string()}));
  ASSERT_TRUE(other.wait_ready().has_value()) << other.output();
  ChildProcess named(in_session(session_.path(), "casd", {second.string(), "--name", "hover"}));
  ASSERT_TRUE(named.wait_ready().has_value()) << named.output();
  ChildProcess killed(in_session(session_.path(), "casd", {second.string()}));
  ASSERT_TRUE(killed.wait_ready().has_value()) << killed.output();
  killed.signal(SIGKILL);
  ASSERT_TRUE(killed.wait_exit().has_value());
  ASSERT_EQ(sockets().size(), 4U);

  EXPECT_THAT(casctl({"arm"}),
              EndedWith(2,
                        "casctl: 3 casds run on this machine: say which with --address or "
                        "CASD_ADDRESS\n",
                        second.string(), "  hover  "));

  const Ended listed = casctl({"--json", "status"});
  EXPECT_EQ(listed.code, 2);
  const json daemons = json::parse(listed.output)["error"]["data"];
  ASSERT_EQ(daemons.size(), 3U) << listed.output;
  for (const json& daemon : daemons) {
    const auto address = daemon["address"].get<std::string>();
    EXPECT_EQ(daemon["vehicles"], address == first ? json{7} : json::array()) << daemon;
    EXPECT_LT(daemon["uptime_s"].get<double>(), 600);
    EXPECT_EQ(casctl({"--address", address, "status"}).code, 0);
  }
  named.signal(SIGTERM);
  other.signal(SIGTERM);
  ASSERT_TRUE(named.wait_exit().has_value() && other.wait_exit().has_value());
  EXPECT_EQ(casctl({"status"}).code, 0) << "one is left";
}

TEST_F(CommandPort, CasctlFindsTheTokenByItself) {
  start("{port: 0}");
  EXPECT_THAT(casctl({"--address", tcp_, "status"}), EndedWith(0));

  fs::rename(runtime() / "casd.token", folder_ / "kept");
  EXPECT_THAT(casctl({"--address", tcp_, "status"}), EndedWith(1, "--token-file"));
  EXPECT_EQ(casctl({"--address", tcp_, "--token-file", (folder_ / "kept").string(), "status"}).code,
            0);
  session_.write("cas/casd.token", "the token of another casd");
  ASSERT_EQ(::chmod((runtime() / "casd.token").c_str(), 0600), 0);
  EXPECT_THAT(casctl({"--address", tcp_, "status"}),
              EndedWith(1, "did not prove that it knows the token in "));
}

/// A program that listens where casd would, on a thread; it keeps every received byte.
class Impostor {
 public:
  /// @param answer  to the request in each line
  explicit Impostor(std::function<json(const json& request)> answer)
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), answer_(std::move(answer)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(fd_, 4), 0);
    socklen_t size = sizeof address;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Impostor() { end(); }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  /// Ends. @return the text that it received
  std::string end() {
    ::shutdown(fd_, SHUT_RDWR);
    if (thread_.joinable()) {
      thread_.join();
      ::close(fd_);
    }
    return told_;
  }

 private:
  void serve() {
    for (int client = 0; (client = ::accept(fd_, nullptr, nullptr)) >= 0; ::close(client)) {
      char buffer[4096];
      std::string line;
      for (ssize_t size = 0; (size = ::recv(client, buffer, sizeof buffer, 0)) > 0;) {
        told_.append(buffer, static_cast<std::size_t>(size));
        line.append(buffer, static_cast<std::size_t>(size));
        if (line.back() != '\n') continue;
        const json request = json::parse(std::exchange(line, ""));
        json reply = answer_(request);
        reply["jsonrpc"] = "2.0";
        reply["id"] = request["id"];
        const std::string text = reply.dump() + "\n";
        ::send(client, text.data(), text.size(), MSG_NOSIGNAL);
      }
    }
  }

  int fd_;
  std::function<json(const json&)> answer_;
  std::uint16_t port_ = 0;
  std::string told_;
  std::thread thread_;
};

json asks_for_token(const json& request) {
  if (request["method"] != "authorise") {
    return {{"error", {{"code", base::rpc::kNotAuthorised}, {"message", "the token, please"}}}};
  }
  return {{"result", {{"nonce", std::string(64, '0')}, {"proof", std::string(64, '0')}}}};
}

TEST_F(CommandPort, CasctlTellsAnImpostorNothingOfTheToken) {
  const std::string token = "0123456789abcdef0123456789abcdef";
  fs::create_directories(runtime());
  session_.write("cas/casd.token", token + "\n");
  ASSERT_EQ(::chmod((runtime() / "casd.token").c_str(), 0600), 0);
  Impostor impostor(asks_for_token);
  EXPECT_THAT(casctl({"--address", impostor.address(), "status"}),
              EndedWith(1, "so it was not told it"));
  const std::string told = impostor.end();
  EXPECT_THAT(told, HasSubstr("nonce"));
  EXPECT_THAT(told, Not(HasSubstr(token)));
  EXPECT_THAT(told, Not(HasSubstr("proof"))) << "it may be passed on: ";
}

TEST_F(CommandPort, CasctlTellsACasdOfBeforeNothingEither) {
  const std::string token = "0123456789abcdef0123456789abcdef";
  fs::create_directories(runtime());
  session_.write("cas/casd.token", token + "\n");
  ASSERT_EQ(::chmod((runtime() / "casd.token").c_str(), 0600), 0);
  Impostor before([](const json& request) -> json {
    const bool nonce = request["method"] == "authorise" && !request["params"].contains("token");
    if (request["method"] == "authorise" && !nonce) return {{"result", true}};
    const int code = nonce ? base::rpc::kInvalidParams : base::rpc::kNotAuthorised;
    return {{"error", {{"code", code}, {"message", "no"}}}};
  });
  EXPECT_THAT(casctl({"--address", before.address(), "status"}), EndedWith(1, "--token-file"));
  // A user who names the token's file allows casctl to send it.
  casctl({"--address", before.address(), "--token-file", (runtime() / "casd.token").string(),
          "status"});
  const std::string told = before.end();
  EXPECT_THAT(told, HasSubstr(token));
  EXPECT_LT(told.find("nonce"), told.find(token)) << told;
}

TEST_F(CommandPort, AnImpostorCannotPassTheProofOn) {
  start("{port: 0}");
  // It passes requests to the real casd, at another port, and returns its answers.
  std::optional<RawClient> real;  // casd waits 10 s for the token: no sooner than it must
  Impostor impostor([&](const json& request) -> json {
    if (!real) real.emplace(port());
    json answer = real->ask(request.dump());
    answer.erase("jsonrpc");
    return answer;
  });
  EXPECT_THAT(casctl({"--address", impostor.address(), "status"}), EndedWith(1, "did not prove"));
  impostor.end();
  ASSERT_TRUE(real);
  EXPECT_EQ(real->ask(kStatus)["error"]["code"], base::rpc::kNotAuthorised);
}

TEST_F(CommandPort, MakesTheTokenFileThatIsConfigured) {
  start("{port: 0, token_file: $DIR/secret}");
  struct stat status {};
  ASSERT_EQ(::lstat((folder_ / "secret").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  EXPECT_FALSE(fs::exists(runtime() / "casd.token"));
  const std::string made = base::rpc::read_token(folder_ / "secret");
  start("{port: 0, token_file: $DIR/secret}");
  EXPECT_EQ(base::rpc::read_token(folder_ / "secret"), made);
  Client client(tcp_);
  EXPECT_EQ(client.call("authorise", {{"token", made}}), true);
}

TEST_F(CommandPort, RefusesATokenThatOthersMayReadOrPlanted) {
  folder_.write("open", "0123456789abcdef0123456789abcdef\n");
  ASSERT_EQ(::chmod((folder_ / "open").c_str(), 0644), 0);
  expect_refused("{port: 0, token_file: $DIR/open}", "set its mode to 0600");
  fs::create_symlink(folder_ / "target", folder_ / "dangling");
  expect_refused("{port: 0, token_file: $DIR/dangling}", "dangling: No such file");
  EXPECT_FALSE(fs::exists(folder_ / "target"));
}

TEST_F(CommandPort, ThisMachineIsExemptOnlyWhereTheTopologySaysSo) {
  start("{port: 0, loopback_without_token: true}");
  EXPECT_EQ(RawClient(port()).ask(kStatus)["result"]["program"], "casd");
  EXPECT_FALSE(fs::exists(runtime() / "casd.token")) << "nobody needs a token";

  start("{port: 0, address: 0.0.0.0}");
  EXPECT_EQ(RawClient(port_of(tcp_)).ask(kStatus)["error"]["code"], base::rpc::kNotAuthorised);
  start("{port: 0, address: 0.0.0.0, loopback_without_token: true}");
  EXPECT_EQ(RawClient(port_of(tcp_)).ask(kStatus)["result"]["program"], "casd");
  EXPECT_TRUE(fs::exists(runtime() / "casd.token")) << "other machines need it";
}

TEST_F(CommandPort, AnEarlierCasdsSocketIsReplacedAndAnotherFileIsNot) {
  const std::string port = "{port: 0, unix: $DIR/casd.sock}";
  start(port);
  expect_refused(port, "casd.sock: is in use by another program");
  EXPECT_EQ(casctl({"--address", "unix:" + (folder_ / "casd.sock").string(), "status"}).code, 0);
  casd_->signal(SIGKILL);
  ASSERT_TRUE(casd_->wait_exit().has_value());
  ASSERT_TRUE(fs::exists(folder_ / "casd.sock")) << "nobody removed it";
  start(port);
  EXPECT_EQ(casctl({"--address", "unix:" + (folder_ / "casd.sock").string(), "status"}).code, 0);

  folder_.write("precious", "data");
  expect_refused("{port: 0, unix: $DIR/precious}", "precious: exists and is no socket");
  EXPECT_EQ(TemporaryFolder::read(folder_ / "precious"), "data");
}

TEST_F(CommandPort, LetsAGroupIn) {
  const group* own = ::getgrgid(::getegid());
  ASSERT_NE(own, nullptr);
  start("{port: 0, unix: $DIR/casd.sock, unix_group: " + std::string(own->gr_name) + "}");
  struct stat status {};
  ASSERT_EQ(::lstat((folder_ / "casd.sock").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0660U);
  EXPECT_EQ(status.st_gid, ::getegid());
  expect_refused("{port: 0, unix: $DIR/other.sock, unix_group: no-such-group}",
                 "there is no group 'no-such-group'");
}

TEST_F(CommandPort, ServesCasctlBesideSilentClientsEverywhere) {
  start("{port: 0, unix: " + (runtime() / "casd.sock").string() + "}");
  std::vector<RawClient> silent;
  for (int i = 1; i <= 64; ++i) {
    const std::string from = "127.0.0." + std::to_string(i);
    silent.emplace_back(port(), from.c_str());
  }
  for (int i = 0; i < 64; ++i) silent.emplace_back((runtime() / "casd.sock").string());
  EXPECT_THAT(casctl({"status"}), EndedWith(0));
}

// Ten seconds each, so that both run at once.
TEST_F(CommandPort, EndsClientsThatAskNothingOrHaveNoToken) {
  start("{port: 0, unix: $DIR/casd.sock}");
  RawClient silent((folder_ / "casd.sock").string());
  RawClient stranger(port());
  EXPECT_EQ(stranger.ask(kStatus)["error"]["code"], base::rpc::kNotAuthorised);
  const json end = stranger.json();
  EXPECT_TRUE(end["id"].is_null());
  EXPECT_EQ(end["error"]["message"], "no token came in time");
  EXPECT_TRUE(stranger.closed_by_server());
  EXPECT_EQ(silent.json()["error"]["message"], "no request came in time");
  EXPECT_TRUE(silent.closed_by_server());
}

TEST_F(CommandPort, TellsOfAReloadThatWasRefused) {
  start("{port: 0, unix: " + (runtime() / "casd.sock").string() + "}");
  EXPECT_THAT(casctl({"status"}).output, Not(HasSubstr("reload")));
  topology("{port: 0, unix: " + (runtime() / "casd.sock").string() + "}",
           std::string(kLinks) + "threads: single\n");
  casd_->signal(SIGHUP);
  Client client("unix:" + (runtime() / "casd.sock").string());
  ASSERT_TRUE(
      wait_until([&] { return client.call("casd.status", json::object()).contains("reload"); }));
  const json reload = client.call("casd.status", json::object())["reload"];
  EXPECT_EQ(reload["accepted"], false);
  EXPECT_THAT(reload["reason"].get<std::string>(), HasSubstr("threads: takes a restart"));
  EXPECT_LT(reload["age_s"].get<double>(), 60);
  const std::string said = casctl({"status"}).output;
  EXPECT_THAT(said, HasSubstr("the last reload, "));
  EXPECT_THAT(said, HasSubstr("was refused: "));
  const std::string found = casctl({"doctor", "--seconds", "0.1"}).output;
  EXPECT_THAT(found, HasSubstr("was refused; the topology before it is in force"));

  topology("{port: 0, unix: " + (runtime() / "casd.sock").string() + "}");
  EXPECT_EQ(casctl({"reload"}).code, 0);
  EXPECT_EQ(client.call("casd.status", json::object())["reload"]["accepted"], true);
  EXPECT_THAT(casctl({"status"}).output, Not(HasSubstr("was refused")));
}

TEST_F(CommandPort, NamesAStreamThatIsSignedInTheFuture) {
  constexpr const char* kPassPhrase = "a pass phrase of the laboratory";
  const fs::path key = folder_.write("radio.key", kPassPhrase);
  ASSERT_EQ(::chmod(key.c_str(), 0600), 0);
  UdpPeer radio;
  start("{port: 0, unix: " + (runtime() / "casd.sock").string() + "}",
        "links:\n  - {name: radio, type: udp, local: '127.0.0.1:0', remote: '" + radio.endpoint() +
            "', signing: {key_file: radio.key}}\n");
  radio.set_remote(link_port("radio"));

  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto now_us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  constexpr mav::SigningTime kTenYears = 3652ULL * 86'400 * mav::kSigningUnitsPerSecond;
  mav::Signing<> wrong(mav::signing_key(kPassPhrase),
                       mav::signing_time(static_cast<std::uint64_t>(now_us)) + kTenYears);
  const auto send = [&] {
    std::array<std::uint8_t, mav::kMaxPacketBytes> out;
    radio.send(
        std::span(out).first(wrong.encode(mavlink::common::Heartbeat{}, {1, 200}, 0, 3, out)));
  };
  Client client("unix:" + (runtime() / "casd.sock").string());
  const auto link = [&] { return client.call("link.list", json::object()).at(0); };
  ASSERT_TRUE(wait_until([&] {
    send();
    return link()["rx"]["signatures"]["too_new"].get<int>() > 0;
  }));
  const json signing = link()["signing"];
  EXPECT_EQ(signing["time_file"], key.string() + ".time");
  EXPECT_LT(signing["time_ahead_s"].get<double>(), 3600);
  EXPECT_NEAR(signing["future"]["ahead_s"].get<double>(), 3652 * 86'400.0, 3600);
  EXPECT_EQ(signing["future"]["link_id"], 3);
  EXPECT_EQ(signing["future"]["refused"], true);

  const std::string status = casctl({"status"}).output;
  EXPECT_THAT(status,
              HasSubstr("link radio: 1/200 (signing link 3) signs 10.0 years ahead of the clock "
                        "and is refused"));
  ChildProcess doctor(in_session(session_.path(), "casctl", {"doctor", "--seconds", "1"}));
  ASSERT_TRUE(wait_until([&] {
    send();
    return doctor.wait_exit(std::chrono::milliseconds(5)).has_value();
  }));
  EXPECT_THAT(doctor.output(),
              HasSubstr("link radio: 1/200 (signing link 3) signs 10.0 years ahead of "
                        "casd's clock and is refused"));
}

/// Between "some restarts" and "wrong" lies one limit, for casd's log, link.list and doctor.
TEST_F(CommandPort, CallsATimeOfSignaturesTooFarAheadInOneVoice) {
  constexpr const char* kPassPhrase = "a pass phrase of the laboratory";
  const fs::path key = folder_.write("radio.key", kPassPhrase);
  ASSERT_EQ(::chmod(key.c_str(), 0600), 0);
  UdpPeer radio;
  const std::string links = "links:\n  - {name: radio, type: udp, local: '127.0.0.1:0', remote: '" +
                            radio.endpoint() + "', signing: {key_file: radio.key}}\n";
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto now_us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  for (const std::uint64_t minutes : {5U, 30U}) {
    const bool wrong = minutes == 30;
    start("{port: 0}", links);
    radio.set_remote(link_port("radio"));
    mav::Signing<> ahead(mav::signing_key(kPassPhrase),
                         mav::signing_time(static_cast<std::uint64_t>(now_us)) +
                             minutes * 60 * mav::kSigningUnitsPerSecond);
    Client client("unix:" + word("command_socket"));
    const auto signing = [&] { return client.call("link.list", json::object())[0]["signing"]; };
    ASSERT_TRUE(wait_until([&] {
      std::array<std::uint8_t, mav::kMaxPacketBytes> out;
      radio.send(std::span(out).first(ahead.encode(
          mavlink::common::Heartbeat{}, {static_cast<std::uint8_t>(minutes), 200}, 0, 3, out)));
      return signing()["time_ahead_s"] > 60.0 * static_cast<double>(minutes) - 60;
    })) << signing();
    EXPECT_EQ(signing()["too_far_ahead"], wrong);
    // It is kept with the next packet that casd signs.
    ASSERT_TRUE(wait_until([&] {
      mav::SigningTime kept = 0;
      std::ifstream(key.string() + ".time") >> kept;
      return kept >= mav::signing_time(static_cast<std::uint64_t>(now_us)) +
                         minutes * 60 * mav::kSigningUnitsPerSecond;
    }));
    const std::string doctor = casctl({"doctor", "--seconds", "0.5"}).output;
    EXPECT_EQ(doctor.find("the time of its signatures is") != std::string::npos, wrong) << doctor;
    stop();
    start("{port: 0}", links);
    stop();
    EXPECT_EQ(casd_->output().find("the time of signatures is") != std::string::npos, wrong)
        << casd_->output();
  }
}

}  // namespace
}  // namespace cas::test

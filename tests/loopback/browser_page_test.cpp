// SPDX-License-Identifier: BSD-3-Clause
// A page of another origin in a real browser tries to command casd. Wants Chromium (scripts/setup
// full).
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "base/os/descriptor.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using base::rpc::RawClient;

constexpr auto kBrowserPatience = std::chrono::seconds(90);

/// The browser's program; empty: none is installed.
std::string browser() {
  const char* folders = ::getenv("PATH");
  std::istringstream path(folders == nullptr ? "" : folders);
  for (std::string folder; std::getline(path, folder, ':');) {
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
      const std::string program = folder + "/" + name;
      if (::access(program.c_str(), X_OK) == 0) return program;
    }
  }
  return "";
}

/// Serves one page for every path, and notes the requests.
class PageServer {
 public:
  PageServer() : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
              0);
    EXPECT_EQ(::listen(listener_.get(), 16), 0);
    socklen_t size = sizeof address;
    ::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~PageServer() {
    ::shutdown(listener_.get(), SHUT_RDWR);  // ends accept()
    if (thread_.joinable()) thread_.join();
  }
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  void serve(std::string page) {
    page_ = std::move(page);
    thread_ = std::thread([this] { run(); });
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }
  /// The page has asked for "/done".
  bool done() const { return done_; }

 private:
  void run() {
    while (true) {
      const base::Descriptor peer(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      if (!peer) return;
      const timeval patience{2, 0};  // browsers open connections ahead and say nothing on them
      ::setsockopt(peer.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
      std::string request(4096, '\0');
      const ssize_t size = ::recv(peer.get(), request.data(), request.size(), 0);
      if (size <= 0) continue;
      if (request.starts_with("GET /done")) done_ = true;
      const std::string answer =
          "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\nContent-Length: " +
          std::to_string(page_.size()) + "\r\n\r\n" + page_;
      ::send(peer.get(), answer.data(), answer.size(), MSG_NOSIGNAL);
    }
  }

  base::Descriptor listener_;
  std::uint16_t port_ = 0;
  std::string page_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

constexpr const char* kReload = R"({"jsonrpc":"2.0","id":1,"method":"casd.reload"})";

/// Every way by which a page can send bytes of its own to another origin.
std::string hostile_page(std::uint16_t port) {
  const std::string casd = "127.0.0.1:" + std::to_string(port);
  return R"(<!doctype html><html><body>
<iframe name="sink"></iframe>
<form id="form" method="post" enctype="text/plain" target="sink" action="http://)" +
         casd + R"(/"><textarea name="a"></textarea></form>
<script>
const lines = '\n' + ')" +
         std::string(kReload) + R"(' + '\n';
const url = 'http://)" +
         casd + R"(/';
async function run() {
  try { await fetch(url, {method: 'POST', mode: 'no-cors', body: lines}); } catch (e) {}
  try { await fetch(url, {method: 'POST', mode: 'no-cors', body: lines.repeat(1000)}); } catch (e) {}
  navigator.sendBeacon(url, lines);
  document.querySelector('textarea').value = lines;
  document.getElementById('form').submit();
  await new Promise(end => {
    const socket = new WebSocket('ws://)" +
         casd + R"(/');
    socket.onopen = () => socket.send(lines);
    socket.onclose = end;
  });
  await new Promise(end => setTimeout(end, 1000));
  await fetch('/done');
}
if (location.pathname == '/') run();
</script></body></html>)";
}

/// casd_command_refused_total{reason="not_json_rpc"}, as Prometheus would read it.
int refused_as_other_protocol(std::uint16_t metrics) {
  RawClient client(metrics);
  client.send("GET /metrics HTTP/1.0\r\n\r\n");
  while (const auto line = client.line()) {
    if (line->find("casd_command_refused_total{reason=\"not_json_rpc\"}") == 0) {
      return std::stoi(line->substr(line->rfind(' ')));
    }
  }
  return -1;
}

TEST(BrowserPage, CommandsNothing) {
  const std::string program = browser();
  if (program.empty()) GTEST_SKIP() << "Chromium is not installed: scripts/setup full";

  const TemporaryFolder folder;
  const auto topology = folder.write(
      "casd.yaml",
      "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\nmetrics: {port: 0}\n"
      "links:\n  - {name: a, type: udp, local: '127.0.0.1:0'}\n");
  RunningCasd casd({kCasdProgram, topology.string()});
  const auto port_in = [&](const std::string& key) { return casd.port(key); };
  const std::uint16_t port = port_in("command_port");

  PageServer server;
  server.serve(hostile_page(port));
  ChildProcess chromium({program, "--headless", "--no-sandbox", "--disable-gpu",
                         "--disable-background-networking", "--disable-dev-shm-usage",
                         "--no-first-run", "--user-data-dir=" + (folder / "profile").string(),
                         server.url()});
  EXPECT_TRUE(wait_until([&] { return server.done(); }, kBrowserPatience)) << chromium.output();
  chromium.signal(SIGTERM);
  chromium.wait_exit();

  // Two of fetch, beacon, form and WebSocket have reached the port; a browser may try some again.
  EXPECT_GE(refused_as_other_protocol(port_in("metrics")), 5) << chromium.output();
  EXPECT_EQ(casd.output().find("casd.reload"), std::string::npos) << casd.output();
  // The same lines do command casd if they do not come from a browser.
  RawClient direct(port);
  EXPECT_EQ(direct.ask(kReload)["result"]["reloaded"], true);
  EXPECT_TRUE(casd.prints("casd.reload: done")) << casd.output();
}

}  // namespace
}  // namespace cas::test

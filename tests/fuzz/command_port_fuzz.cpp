// SPDX-License-Identifier: BSD-3-Clause
// Any bytes at the command port: the real server, session, dispatcher and methods over a Unix
// socket, with a vehicle behind them that accepts everything, in virtual time.
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "base/os/log.hpp"
#include "base/rpc/server.hpp"
#include "casd/counters/echo_latency.hpp"
#include "casd/port/figure_methods.hpp"
#include "casd/port/vehicle_methods.hpp"
#include "tests/casd/fake_vehicle.hpp"

namespace {

using namespace cas;
using namespace cas::casd;
using std::chrono::milliseconds;

class FuzzedPort {
 public:
  FuzzedPort() {
    std::string pattern = std::filesystem::temp_directory_path() / "cas-fuzz-XXXXXX";
    folder_ = ::mkdtemp(pattern.data());
    server_.listen_unix(folder_ / "port");
    topology_.links.push_back({});
    topology_.links.back().name = "fcu";
    figures_.add_link(0, "fcu", LinkType::kSerial);
    vehicle_.params = {{"MC_ROLLRATE_P", {.value = 0.15}}};
    vehicle_.say_heartbeat(now_);
    turn();
  }
  ~FuzzedPort() {
    server_.close();
    std::filesystem::remove_all(folder_);
  }

  void feed(std::span<const std::uint8_t> bytes) {
    const int client = connect();
    for (int turns = 0; turns < kMaxTurns; ++turns) {
      if (!bytes.empty()) {
        const ssize_t sent = ::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        bytes = sent > 0 ? bytes.subspan(static_cast<std::size_t>(sent)) : bytes.first(0);
        if (bytes.empty()) ::shutdown(client, SHUT_WR);
      }
      turn();
      if (ended(client)) break;
    }
    ::close(client);
    turn();
  }

 private:
  static constexpr int kMaxTurns = 200;

  int connect() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, (folder_ / "port").c_str(), sizeof address.sun_path - 1);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) ::abort();
    turn();
    return fd;
  }
  /// Drops the answers. @return whether the server has ended the connection
  static bool ended(int client) {
    char answers[65536];
    for (;;) {
      const ssize_t size = ::recv(client, answers, sizeof answers, 0);
      if (size < 0 && errno == EAGAIN) return false;
      if (size <= 0) return true;
    }
  }
  /// Some virtual time: retries and timeouts pass quickly.
  void turn() {
    io_.restart();
    io_.poll();
    now_ += milliseconds(100);
    while (const auto packet = vehicle_.take(now_)) {
      commander_.on_packet(0, mav::view_packet(packet->view()), now_);
    }
    commander_.tick(now_);
    io_.restart();
    io_.poll();
  }

  base::RunTime now_{std::chrono::hours(1)};
  std::filesystem::path folder_;
  boost::asio::io_context io_;
  base::rpc::Server server_{io_};
  casd::test::FakeVehicle vehicle_;
  VehicleCommander commander_{{},
                              [this](std::span<const std::uint8_t> packet, std::span<const Path>) {
                                vehicle_.handle(mav::view_packet(packet), now_);
                              }};
  Topology topology_;
  LinkFigures figures_;
  MessageTaps taps_;
  EchoLatency echo_;
  VehicleMethods vehicle_methods_{server_,
                                  commander_,
                                  GainMap::shipped(),
                                  {.now = [this] { return now_; },
                                   .link_name = [](LinkId) { return std::string("fcu"); },
                                   .audit = [](const std::string&) {}}};
  FigureMethods figure_methods_{server_,
                                {.figures = &figures_,
                                 .topology = [this]() -> const Topology& { return topology_; },
                                 .now = [this] { return now_; },
                                 .started = now_,
                                 .vehicles = [this] { return vehicle_methods_.vehicles(); },
                                 .taps = &taps_,
                                 .echo = &echo_}};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static FuzzedPort port;
  port.feed({data, size});
  return 0;
}

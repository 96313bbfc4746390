// SPDX-License-Identifier: BSD-3-Clause
// A fleet whose telemetry casd carries to several ground stations, each vehicle and station on a
// link of its own; counts what was lost. `scripts/bench_router --only fleet` runs it.
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "base/rpc/client.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

using mavlink::common::Attitude;
using nlohmann::json;

struct Load {
  int vehicles = 100;
  int stations = 4;
  double hz = 50;
  double seconds = 10;
  std::string casd = binary_dir() + "/bin/casd";

  int packets() const { return static_cast<int>(hz * seconds); }  ///< of each vehicle
};

double now_us() {
  return std::chrono::duration<double, std::micro>(base::steady_now().time_since_epoch()).count();
}

/// User and system time that a process has used, in microseconds.
double cpu_us(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  std::istringstream fields(text.substr(text.rfind(')') + 2));
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0;
  double system = 0;
  fields >> user >> system;
  return (user + system) * 1e6 / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

/// The ends of all links.
class Fleet {
 public:
  explicit Fleet(const Load& load) : load_(load), sent_(slots()) {
    for (int i = 0; i < load.vehicles; ++i) vehicles_.push_back(std::make_unique<Vehicle>(i));
    for (int i = 0; i < load.stations; ++i) stations_.push_back(std::make_unique<Station>());
    for (const auto& station : stations_) station->delay_us.assign(slots(), -1);
  }

  std::string topology(std::uint16_t command) const {
    std::string yaml = "schema: 1\ncommand_port: {port: " + std::to_string(command) +
                       ", loopback_without_token: true}\ncommanding: {heartbeat_hz: 0}\nlinks:\n";
    std::string vehicles;
    std::string stations;
    const auto add = [&yaml](std::string& names, const std::string& name, const UdpPeer& end) {
      yaml += "  - {name: " + name + ", type: udp, remote: \"" + end.endpoint() + "\"}\n";
      names += (names.empty() ? "" : ", ") + name;
    };
    for (std::size_t i = 0; i < vehicles_.size(); ++i) {
      add(vehicles, "v" + std::to_string(i), vehicles_[i]->socket);
    }
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      add(stations, "s" + std::to_string(i), stations_[i]->socket);
    }
    return yaml + "routes:\n  - {from: [" + vehicles + "], to: [" + stations + "]}\n  - {from: [" +
           stations + "], to: [" + vehicles + "]}\n";
  }

  /// Tells each vehicle where casd hears it. @return whether all links are up
  bool meet(base::rpc::Client& casd) {
    const json links = casd.call("link.list", json::object());
    for (const json& link : links) {
      if (link["state"] != "up") return false;
      const std::string name = link["name"];
      if (name[0] != 'v') continue;
      vehicles_.at(std::stoul(name.substr(1)))->socket.set_remote(port_of(link["endpoint"]));
    }
    return links.size() == vehicles_.size() + stations_.size();
  }

  /// All packets on an even grid, and a moment for those on their way.
  void run() {
    std::atomic<bool> over{false};
    std::thread reader([&] {
      while (!over.load()) read();
    });
    send();
    std::this_thread::sleep_for(std::chrono::seconds(1));
    over.store(true);
    reader.join();
    read();
  }

  json report(double cpu) const {
    json lost = json::array();
    std::vector<double> delays;
    for (const auto& station : stations_) {
      lost.push_back(std::ranges::count(station->delay_us, -1.0));
      std::ranges::copy_if(station->delay_us, std::back_inserter(delays),
                           [](double delay) { return delay >= 0; });
    }
    std::ranges::sort(delays);
    const auto quantile = [&](double q) {
      if (delays.empty()) return 0.0;
      return delays[static_cast<std::size_t>(q * static_cast<double>(delays.size() - 1))];
    };
    return {{"vehicles", load_.vehicles},
            {"hz", load_.hz},
            {"stations", load_.stations},
            {"sent", slots()},
            {"delivered", delays.size()},
            {"lost", lost},
            {"delay_us", {{"p50", quantile(0.50)}, {"p99", quantile(0.99)}}},
            {"cpu_us_per_delivery", delays.empty() ? 0 : cpu / static_cast<double>(delays.size())}};
  }

 private:
  struct Vehicle {
    explicit Vehicle(int number) : encoder({static_cast<std::uint8_t>(1 + number), 1}) {}
    UdpPeer socket;
    mav::Encoder encoder;
  };
  struct Station {
    UdpPeer socket;
    PacketStream stream;
    std::vector<double> delay_us;  ///< by packet; below 0: it has not come
  };

  std::size_t slots() const {
    return static_cast<std::size_t>(load_.vehicles) * static_cast<std::size_t>(load_.packets());
  }
  std::size_t slot(std::size_t vehicle, std::uint32_t number) const {
    return vehicle * static_cast<std::size_t>(load_.packets()) + number;
  }

  void send() {
    const double period_us = 1e6 / (load_.hz * load_.vehicles);
    const double begin = now_us();
    std::size_t turn = 0;
    for (int number = 0; number < load_.packets(); ++number) {
      for (std::size_t i = 0; i < vehicles_.size(); ++i, ++turn) {
        const double due = begin + static_cast<double>(turn) * period_us;
        if (const double wait = due - now_us(); wait > 1000) {
          std::this_thread::sleep_for(std::chrono::duration<double, std::micro>(wait));
        }
        Attitude attitude;
        attitude.time_boot_ms = static_cast<std::uint32_t>(number);
        sent_[slot(i, attitude.time_boot_ms)].store(now_us());
        vehicles_[i]->socket.send(vehicles_[i]->encoder(attitude));
      }
    }
  }

  void read() {
    for (const auto& station : stations_) {
      station->socket.read(station->stream);
      const double now = now_us();
      for (auto& packets = station->stream.packets(); !packets.empty(); packets.pop_front()) {
        const auto attitude = mav::decode<Attitude>(packets.front().view());
        if (!attitude) continue;
        const std::size_t at = slot(packets.front().source.system - 1U, attitude->time_boot_ms);
        station->delay_us.at(at) = now - sent_[at].load();
      }
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }

  Load load_;
  std::vector<std::unique_ptr<Vehicle>> vehicles_;
  std::vector<std::unique_ptr<Station>> stations_;
  std::vector<std::atomic<double>> sent_;  ///< when, by packet
};

int run(const Load& load) {
  const TemporaryFolder folder;
  Fleet fleet(load);
  const std::uint16_t command = free_port();
  ChildProcess casd({load.casd, folder.write("fleet.yaml", fleet.topology(command))});
  if (!casd.wait_ready()) {
    std::fprintf(stderr, "casd did not start: %s\n", casd.output().c_str());
    return 1;
  }
  base::rpc::Client client("127.0.0.1:" + std::to_string(command));
  if (!wait_until([&] { return fleet.meet(client); })) return 1;
  const double before = cpu_us(casd.pid());
  fleet.run();
  std::puts(fleet.report(cpu_us(casd.pid()) - before).dump().c_str());
  return 0;
}

}  // namespace
}  // namespace cas::test

int main(int argc, char** argv) {
  cas::test::Load load;
  CLI::App cli("Measures what casd loses of a fleet's telemetry.", "fleet_load");
  cli.add_option("--vehicles", load.vehicles)->check(CLI::Range(1, 245))->capture_default_str();
  cli.add_option("--stations", load.stations)->check(CLI::Range(1, 5))->capture_default_str();
  cli.add_option("--hz", load.hz, "Of each vehicle")->check(CLI::Range(1, 1000));
  cli.add_option("--seconds", load.seconds)->check(CLI::Range(1, 600))->capture_default_str();
  cli.add_option("--casd", load.casd, "The program");
  CLI11_PARSE(cli, argc, argv);
  return cas::test::run(load);
}

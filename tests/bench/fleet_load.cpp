// SPDX-License-Identifier: BSD-3-Clause
// A fleet whose telemetry casd carries to several ground stations, each vehicle and station on a
// link of its own; counts lost packets. `scripts/bench_router --only fleet` runs it.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "base/rpc/client.hpp"
#include "tests/bench/fleet.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

struct Load : FleetLoad {
  std::string casd = binary_dir() + "/bin/casd";
};

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

/// All packets on an even grid, and a moment for those on their way.
void carry_all(Fleet& fleet) {
  std::atomic<bool> over{false};
  std::thread reader([&] {
    while (!over.load()) {
      fleet.read(base::steady_now());
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  });
  while (!fleet.send_due(base::steady_now())) {
    const base::Duration wait = fleet.next_due() - base::steady_now();
    if (wait > std::chrono::milliseconds(1)) std::this_thread::sleep_for(wait);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  over.store(true);
  reader.join();
  fleet.read(base::steady_now());
}

json report(const Load& load, const Fleet& fleet, double cpu) {
  const std::vector<std::size_t> missing = fleet.missing();
  const std::size_t lost = std::accumulate(missing.begin(), missing.end(), std::size_t{0});
  const std::size_t delivered = fleet.total() * missing.size() - lost;
  return {{"vehicles", load.vehicles},
          {"hz", load.hz},
          {"kinds", load.kinds},
          {"stations", load.stations},
          {"sent", fleet.total()},
          {"delivered", delivered},
          {"lost", missing},
          {"repeated", fleet.repeated()},
          {"delay_us", {{"p50", fleet.delay_us(0.50)}, {"p99", fleet.delay_us(0.99)}}},
          {"cpu_us_per_delivery", delivered == 0 ? 0 : cpu / static_cast<double>(delivered)}};
}

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
  carry_all(fleet);
  std::puts(report(load, fleet, cpu_us(casd.pid()) - before).dump().c_str());
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
  cli.add_option("--kinds", load.kinds, "Of messages, one after the other")
      ->check(CLI::Range(1, cas::test::FleetLoad::kMostKinds))
      ->capture_default_str();
  cli.add_option("--casd", load.casd, "The program");
  CLI11_PARSE(cli, argc, argv);
  return cas::test::run(load);
}

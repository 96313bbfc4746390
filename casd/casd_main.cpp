// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/cpu_latency.hpp"
#include "base/os/program.hpp"
#include "base/os/thread.hpp"
#include "casd/app.hpp"
#include "casd/topology_text.hpp"

namespace {

using namespace cas;

struct Flags {
  std::string topology;
  std::string ledger;
  std::string stats;
  std::string log_level = "info";
  bool check = false;
  bool lockstep = false;
};

int run(const Flags& flags) {
  const std::filesystem::path file = base::find_config(flags.topology);
  casd::Topology topology = casd::Topology::load(file);
  if (flags.lockstep) topology.set_lockstep();
  if (flags.check) {
    casd::check_named_files(topology);
    std::printf("%s: %zu links, %zu routes\n", flags.topology.c_str(), topology.links.size(),
                topology.routes.size());
    std::fputs(casd::topology_text(topology).c_str(), stdout);
    return base::kExitOk;
  }
  if (topology.lock_memory) base::lock_memory();
  const base::CpuLatencyRequest latency(topology.cpu_dma_latency_us);
  casd::App app({.topology_file = file, .ledger_file = flags.ledger, .stats_file = flags.stats},
                std::move(topology));
  base::bind_command_port([&app] { app.listen(); });
  app.run();
  return base::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  Flags flags;
  CLI::App cli("Routes MAVLink between simulator, flight controller and ground stations.", "casd");
  cli.set_version_flag("--version", std::string("casd ") + CAS_VERSION);
  cli.add_option("topology", flags.topology, "Links and routes (YAML)")->required();
  cli.add_flag("--check", flags.check, "Read the topology, say what is wrong, and end");
  cli.add_option("--ledger", flags.ledger,
                 "Write each HIL packet at each link to this file at the end");
  cli.add_flag("--lockstep", flags.lockstep,
               "Run every protocol timer on the stream's time, as 'pace: lockstep' does");
  cli.add_option("--stats", flags.stats, "Write figures to this file at the end");
  cli.add_option("--log-level", flags.log_level, "Level: debug, info, warn, error or off");
  base::cli::add_manual(cli, "casd", CAS_VERSION);
  if (const auto ended = base::cli::parse(cli, argc, argv, base::kExitConfig)) return *ended;
  return base::run_program("casd", flags.log_level, [&] { return run(flags); });
}

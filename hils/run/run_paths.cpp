// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/run_paths.hpp"

#include <sys/un.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/rpc/local_port.hpp"
#include "hils/run/loopback_udp.hpp"

namespace cas::hils {

namespace {

std::filesystem::path parent_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime != nullptr && ::access(runtime, W_OK) == 0) return runtime;
  return std::filesystem::temp_directory_path();
}

/// "casd-NAME.sock" for a run's folder NAME.
std::optional<std::filesystem::path> socket_in_runtime_folder(const std::filesystem::path& run) {
  try {
    std::filesystem::path socket =
        base::rpc::make_runtime_folder() / ("casd-" + run.filename().string() + ".sock");
    if (socket.native().size() < sizeof(sockaddr_un::sun_path)) return socket;
  } catch (const base::ConfigError&) {
    // There is none that is this user's alone.
  }
  return std::nullopt;
}

}  // namespace

RunDirectory::RunDirectory()
    : folder_(parent_folder(), "hils"),
      command_socket_(socket_in_runtime_folder(path()).value_or(path() / "casd")) {}

RunDirectory::~RunDirectory() {
  std::error_code ignored;
  std::filesystem::remove(command_socket_, ignored);  // of a casd that was killed
}

std::vector<std::uint16_t> free_udp_ports(std::size_t count) {
  std::vector<LoopbackUdp> sockets;  // all open at once, so that the ports differ
  std::vector<std::uint16_t> ports;
  for (std::size_t i = 0; i < count; ++i) {
    ports.push_back(sockets.emplace_back("there is no free UDP port").port());
  }
  return ports;
}

RunPaths RunPaths::of(const Scenario& scenario, const std::filesystem::path& out,
                      const std::filesystem::path& sockets) {
  RunPaths paths{.out = out,
                 .run = out / "run",
                 .sockets = sockets,
                 .command_port = sockets / "casd",
                 .vehicles = {}};
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    VehiclePaths& vehicle = paths.vehicles.emplace_back();
    vehicle.out = paths.out;
    vehicle.run = paths.run;
    vehicle.sockets = paths.sockets;
    vehicle.tty = "fcu" + std::to_string(i);
    vehicle.suffix = scenario.suffix_of(i);
    if (!scenario.flies_several()) continue;
    vehicle.simulator_link += std::to_string(i + 1);
    vehicle.controller_link += std::to_string(i + 1);
  }
  return paths;
}

void RunPaths::choose_ports() {
  const std::vector<std::uint16_t> ports = free_udp_ports(2 * vehicles.size());
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    vehicles[i].simulator_port = ports[2 * i];
    vehicles[i].casd_port = ports[2 * i + 1];
  }
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/run_places.hpp"

#include "hils/run/run_directory.hpp"

namespace cas::hils {

RunPlaces RunPlaces::of(const Scenario& scenario, const std::filesystem::path& out,
                        const std::filesystem::path& sockets) {
  RunPlaces places{.out = out, .run = out / "run", .sockets = sockets, .vehicles = {}};
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    VehiclePlaces& vehicle = places.vehicles.emplace_back();
    vehicle.out = places.out;
    vehicle.run = places.run;
    vehicle.sockets = places.sockets;
    vehicle.tty = "fcu" + std::to_string(i);
    if (!scenario.flies_several()) continue;
    vehicle.suffix = "_" + scenario.vehicles[i].name;
    vehicle.simulator_link += std::to_string(i + 1);
    vehicle.controller_link += std::to_string(i + 1);
  }
  return places;
}

void RunPlaces::choose_ports() {
  const std::vector<std::uint16_t> ports = free_udp_ports(2 * vehicles.size());
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    vehicles[i].simulator_port = ports[2 * i];
    vehicles[i].casd_port = ports[2 * i + 1];
  }
}

}  // namespace cas::hils

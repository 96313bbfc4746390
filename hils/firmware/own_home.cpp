// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/own_home.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "base/earth/deg_e7.hpp"
#include "base/earth/geodesy.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "mavlink/common/home_position.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {
namespace {

/// A stock autopilot's home is off by as much.
constexpr double kOff_m = 2;

std::optional<base::Geodetic> first_home(const std::filesystem::path& tlog, std::uint8_t system) {
  std::optional<base::Geodetic> first;
  casd::for_each_tlog_packet(tlog, mavlink::common::table(),
                             [&](std::uint64_t, const mav::PacketView& packet) {
                               if (first || packet.source.system != system) return;
                               const auto home = mav::decode<mavlink::common::HomePosition>(packet);
                               if (!home) return;
                               first = {.lat_deg = base::degrees_of_e7(home->latitude),
                                        .lon_deg = base::degrees_of_e7(home->longitude)};
                             });
  return first;
}

}  // namespace

std::optional<std::string> home_fault(const Scenario& scenario, std::size_t vehicle,
                                      const std::filesystem::path& tlog, std::uint8_t system) {
  const auto home = first_home(tlog, system);
  if (!home || !scenario.home) return std::nullopt;
  const Eigen::Vector2d home_m = base::LocalProjection(*scenario.home)
                                     .to_local({home->lat_deg, home->lon_deg, scenario.home->alt_m})
                                     .head<2>();
  std::vector<Eigen::Vector2d> starts;  // north, east; a pose is x to the east, y to the north
  for (const ScenarioVehicle& each : scenario.vehicles) {
    starts.emplace_back(each.pose.y_m, each.pose.x_m);
  }
  const auto off_m = [&home_m](const Eigen::Vector2d& start) { return (home_m - start).norm(); };
  const auto nearest = std::ranges::min_element(starts, {}, off_m);
  if (off_m(starts.at(vehicle)) <= off_m(*nearest) + kOff_m) return std::nullopt;
  return fmt::format("system {} has its home where vehicle '{}' started, and not '{}'", system,
                     scenario.vehicles.at(static_cast<std::size_t>(nearest - starts.begin())).name,
                     scenario.vehicles.at(vehicle).name);
}

}  // namespace cas::hils

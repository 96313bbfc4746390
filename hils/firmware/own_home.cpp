// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/own_home.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "base/config/config.hpp"
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

base::Geodetic origin_of(const base::ConfigNode& world) {
  const base::ConfigNode home = world.at("home");
  return {.lat_deg = home.require<double>("lat_deg"),
          .lon_deg = home.require<double>("lon_deg"),
          .alt_m = home.require<double>("alt_m")};
}

/// Where the vehicles start: north, east. A pose is x to the east, y to the north.
std::vector<Eigen::Vector2d> starts_m(const base::ConfigNode& world, std::size_t count) {
  std::vector<Eigen::Vector2d> starts;
  const auto vehicles = world.at("vehicles").items();
  for (std::size_t i = 0; i < count; ++i) {
    const auto pose = vehicles.at(i).find("pose");
    starts.emplace_back(pose ? pose->get("y_m", 0.0) : 0.0, pose ? pose->get("x_m", 0.0) : 0.0);
  }
  return starts;
}

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

std::optional<std::string> home_fault(const FirmwareScenario& scenario, std::size_t vehicle,
                                      const std::filesystem::path& tlog, std::uint8_t system) {
  const auto home = first_home(tlog, system);
  const base::ConfigNode world = base::ConfigNode::load(scenario.world);
  if (!home || !world.has("home")) return std::nullopt;
  const base::Geodetic origin = origin_of(world);
  const Eigen::Vector2d home_m = base::LocalProjection(origin)
                                     .to_local({home->lat_deg, home->lon_deg, origin.alt_m})
                                     .head<2>();
  const auto starts = starts_m(world, scenario.vehicles.size());
  const auto off_m = [&home_m](const Eigen::Vector2d& start) { return (home_m - start).norm(); };
  const auto nearest = std::ranges::min_element(starts, {}, off_m);
  if (off_m(starts.at(vehicle)) <= off_m(*nearest) + kOff_m) return std::nullopt;
  return fmt::format("system {} has its home where vehicle '{}' started, and not '{}'", system,
                     scenario.vehicles.at(static_cast<std::size_t>(nearest - starts.begin())),
                     scenario.vehicles.at(vehicle));
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/vehicle_state.hpp"

#include <algorithm>

#include "base/earth/deg_e7.hpp"
#include "base/earth/geodesy.hpp"

namespace cas::casd {

bool VehicleState::is_at(const Origin& from, base::RunTime now) const {
  const auto is = [&](const Way& way) { return way.path == from.path; };
  if (std::any_of(ways_.begin(), ways_.end(), is)) return true;
  if (from.group < 0 || from.group != group_) return false;
  // A redundant way; on a server link another peer only replaces one that has fallen silent.
  return std::none_of(ways_.begin(), ways_.end(), [&](const Way& way) {
    return way.path.link == from.path.link && now - way.at <= kVehicleTimeout;
  });
}

void VehicleState::on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now) {
  heard_over(from, now);
  mav::services::VehicleState::on_packet(packet, now);
}

void VehicleState::heard_over(const Origin& from, base::RunTime now) {
  group_ = from.group;
  const auto same_link = std::find_if(
      ways_.begin(), ways_.end(), [&](const Way& way) { return way.path.link == from.path.link; });
  if (same_link == ways_.end()) {
    ways_.push_back({from.path, now});
  } else {
    *same_link = {from.path, now};
  }
  if (now - ways_.front().at <= kVehicleTimeout) return;
  const auto speaking = std::find_if(ways_.begin(), ways_.end(),
                                     [&](const Way& way) { return way.path == from.path; });
  std::iter_swap(ways_.begin(), speaking);
}

bool VehicleState::forget(const LinkMask& links) {
  std::erase_if(ways_, [&](const Way& way) { return links.has(way.path.link); });
  return !ways_.empty();
}

std::vector<Path> VehicleState::paths() const {
  std::vector<Path> all;
  for (const Way& way : ways_) all.push_back(way.path);
  return all;
}

bool VehicleState::hangs_on(LinkId link, base::RunTime now) const {
  return std::ranges::any_of(ways_, [&](const Way& way) { return way.path.link == link; }) &&
         std::ranges::none_of(ways_, [&](const Way& way) {
           return way.path.link != link && now - way.at <= kVehicleTimeout;
         });
}

std::optional<Rival> VehicleState::rival(base::RunTime now) const {
  if (!rival_ || now - rival_->at > kVehicleTimeout) return std::nullopt;
  return rival_;
}

std::optional<HomeAmsl> VehicleState::home() const {
  if (const auto& told = told_home()) {
    const mavlink::common::HomePosition& home = told->message;
    return HomeAmsl{base::degrees_of_e7(home.latitude),
                    base::degrees_of_e7(home.longitude),
                    home.altitude * 1e-3,
                    home.x,
                    home.y,
                    home.z};
  }
  if (!global_position() || !local_position()) return std::nullopt;
  const mavlink::common::GlobalPositionInt& here = global_position()->message;
  const mavlink::common::LocalPositionNed& local = local_position()->message;
  const base::Geodetic place{base::degrees_of_e7(here.lat), base::degrees_of_e7(here.lon),
                             here.alt * 1e-3};
  const base::Geodetic origin =
      base::LocalProjection(place).to_geodetic({-double{local.x}, -double{local.y}, 0});
  const double alt_m = (here.alt - here.relative_alt) * 1e-3;
  const double z_m = double{local.z} + here.relative_alt * 1e-3;
  return HomeAmsl{origin.lat_deg, origin.lon_deg, alt_m, 0, 0, z_m};
}

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/lidar/obstacle_sectors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace cas::sim {
namespace {

namespace mv = mavlink::common;

constexpr double kSectorWidth_deg = 5;
constexpr std::uint16_t kUnknownSector = 0xFFFF;
constexpr double kCmPerM = 100;

/// Leaves room for max_distance + 1, "free", below kUnknownSector.
std::uint16_t whole_cm(double metres) {
  return static_cast<std::uint16_t>(
      std::clamp(std::round(metres * kCmPerM), 0.0, kUnknownSector - 2.0));
}

}  // namespace

std::size_t ObstacleSectors::sector_of(double azimuth_rad) {
  constexpr double kSectorWidth = kSectorWidth_deg * M_PI / 180;
  const auto number = static_cast<long>(std::lround(azimuth_rad / kSectorWidth));
  constexpr auto kAll = static_cast<long>(kSectors);
  return static_cast<std::size_t>(((number % kAll) + kAll) % kAll);
}

void ObstacleSectors::see_free(double azimuth_rad) { sectors_[sector_of(azimuth_rad)].seen = true; }

void ObstacleSectors::see_obstacle(double azimuth_rad, double distance_m) {
  Sector& sector = sectors_[sector_of(azimuth_rad)];
  sector.distance_m = sector.hit ? std::min(sector.distance_m, distance_m) : distance_m;
  sector.seen = sector.hit = true;
}

mv::ObstacleDistance ObstacleSectors::message(base::SimTime time, double min_m,
                                              double max_m) const {
  mv::ObstacleDistance packet;
  packet.time_usec = base::to_time_usec(time);
  packet.sensor_type = mv::MavDistanceSensor::kLaser;
  packet.increment = static_cast<std::uint8_t>(kSectorWidth_deg);
  packet.increment_f = static_cast<float>(kSectorWidth_deg);
  packet.min_distance = whole_cm(min_m);
  packet.max_distance = whole_cm(max_m);
  packet.frame = mv::MavFrame::kBodyFrd;
  for (std::size_t i = 0; i < kSectors; ++i) {
    const Sector& sector = sectors_[i];
    std::uint16_t& distance = packet.distances[i];
    if (!sector.seen) {
      distance = kUnknownSector;
    } else if (!sector.hit) {
      distance = static_cast<std::uint16_t>(packet.max_distance + 1);
    } else {
      distance = std::min(whole_cm(sector.distance_m), packet.max_distance);
    }
  }
  return packet;
}

}  // namespace cas::sim

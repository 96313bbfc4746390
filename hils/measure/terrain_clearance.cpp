// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/terrain_clearance.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>

#include "hils/measure/struck_object.hpp"
#include "hils/measure/true_steps.hpp"
#include "libsim/core/terrain/terrain.hpp"

namespace cas::hils {
namespace {

bool has_terrain_leg(const Stage& stage) {
  return std::ranges::count(stage.step.places, true, &MissionPlace::above_terrain) >= 2;
}

/// Samples between the first and the last waypoint above terrain; none where one was not passed.
std::span<const PoseSample> over_terrain(const Stage& stage, const Eigen::Vector3d& origin_m,
                                         std::span<const PoseSample> flown) {
  const std::vector<MissionPlace>& places = stage.step.places;
  const std::vector<std::size_t> passed = passings(places, origin_m, flown);
  const auto first = std::ranges::find(places, true, &MissionPlace::above_terrain);
  const auto last = std::find_if(places.rbegin(), places.rend(),
                                 [](const MissionPlace& place) { return place.above_terrain; });
  const auto begin = static_cast<std::size_t>(first - places.begin());
  const auto end = static_cast<std::size_t>(last.base() - places.begin()) - 1;
  if (end >= passed.size()) return {};
  return flown.subspan(passed[begin], passed[end] - passed[begin]);
}

}  // namespace

std::optional<TerrainClearance> terrain_clearance(
    const std::vector<Stage>& stages, std::span<const PoseSample> truth,
    const std::function<double(double, double)>& ground_m) {
  std::optional<TerrainClearance> clearance;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  for (const Stage& stage : stages) {
    const auto begun = between(truth, to_microseconds(stage.begin), to_microseconds(stage.end));
    if (begun.empty()) continue;
    const Pose& start = begun.front().pose;
    if (takes_off(stage.step)) origin_m = {start.x_m, start.y_m, start.z_m};
    if (!has_terrain_leg(stage)) continue;
    const auto flown = between(begun, to_microseconds(stage.accepted), to_microseconds(stage.end));
    for (const PoseSample& sample : over_terrain(stage, origin_m, flown)) {
      const double height_m = sample.pose.z_m - ground_m(sample.pose.x_m, sample.pose.y_m);
      if (!clearance) clearance = {height_m, height_m};
      clearance->least_m = std::min(clearance->least_m, height_m);
      clearance->most_m = std::max(clearance->most_m, height_m);
    }
  }
  return clearance;
}

std::optional<TerrainClearance> terrain_clearance(const std::vector<Stage>& stages,
                                                  std::span<const PoseSample> truth,
                                                  const std::filesystem::path& simulator_config) {
  if (std::ranges::none_of(stages, has_terrain_leg)) return std::nullopt;
  const std::optional<sim::WorldModel> world = flown_world(simulator_config);
  if (!world || !world->terrain) return std::nullopt;
  const sim::Terrain& terrain = *world->terrain;
  return terrain_clearance(stages, truth, [&](double north_m, double east_m) {
    return terrain.height_m(east_m, north_m);
  });
}

}  // namespace cas::hils

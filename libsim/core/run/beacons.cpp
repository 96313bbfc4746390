// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/beacons.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "base/suggestion.hpp"
#include "libsim/core/run/sim_world.hpp"
#include "libsim/core/run/start.hpp"

namespace cas::sim {
namespace {

const MovingObstacle& carrier_of(const BeaconConfig& beacon, const WorldModel& model) {
  const auto found = std::ranges::find(model.moving, *beacon.on, &MovingObstacle::name);
  if (found != model.moving.end()) return *found;
  std::vector<std::string> names;
  for (const MovingObstacle& obstacle : model.moving) names.push_back(obstacle.name);
  beacon.node.at("on").fail("the world has no moving obstacle '" + *beacon.on + "'" +
                            base::did_you_mean(*beacon.on, names));
}

}  // namespace

BeaconSource beacon_source(const BeaconConfig& beacon, const WorldModel& model,
                           const SimWorld& world) {
  Eigen::Vector3d p(beacon.x_m, beacon.y_m, beacon.z_m.value_or(0));
  if (beacon.on) {
    return {[&path = carrier_of(beacon, model).path, p](base::SimTime time) {
      const BodyState carrier = path.at(base::to_seconds(time));
      return Eigen::Vector3d(carrier.p_WB + carrier.q_WB * p);
    }};
  }
  if (!beacon.z_m) {
    const auto surface = surface_at(world, beacon.x_m, beacon.y_m);
    if (!surface) beacon.node.fail("needs z_m: there is nothing below it");
    p.z() = *surface;
  }
  return {[p](base::SimTime) { return p; }};
}

}  // namespace cas::sim

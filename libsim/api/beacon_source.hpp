// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <string_view>

#include "base/time/clock.hpp"

namespace cas::sim {

/// A beacon of the world, to be seen by sensors. The host advertises topic `beacon/NAME` for each
/// before it configures the plugins, and publishes on it once, before time zero.
struct BeaconSource {
  static constexpr std::string_view kTypeName = "cas.BeaconSource";
  static constexpr unsigned kTypeVersion = 1;
  /// Topic of the beacon of this name.
  static std::string topic(const std::string& name) { return "beacon/" + name; }
  /// Place of the beacon in W at a time of the simulation, m.
  std::function<Eigen::Vector3d(base::SimTime)> place_W;
};

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "base/config/vehicle.hpp"

namespace cas::sim {

/// Topic of a vehicle on which plugin `fault` says which servos are broken.
inline constexpr std::string_view kSurfaceHealth = "surface_health";

/// What is wrong with the servo of a control surface.
struct ServoHealth {
  double rate_share = 1;             ///< of its fastest rate; 0: the surface stays where it is
  bool reversed = false;             ///< it turns to the other side of what is asked
  std::optional<double> held_rad{};  ///< it turns there, whatever is asked
};

/// Servos of the control surfaces, in the order of the vehicle file; as they are made if nothing is
/// broken.
struct SurfaceHealth {
  static constexpr std::string_view kTypeName = "cas.SurfaceHealth";
  static constexpr unsigned kTypeVersion = 1;
  std::array<ServoHealth, base::kMaxOutputs> servos{};
};

}  // namespace cas::sim

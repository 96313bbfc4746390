// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/export.hpp"

namespace cas::base {

/// A frame as stock autopilots number its rotors: an entry of config/frames.yaml.
struct CAS_BASE_EXPORT Frame {
  /// FRAME_CLASS and FRAME_TYPE.
  struct ArduPilot {
    int frame_class = 0;
    int frame_type = 0;
  };
  struct Place {
    double angle_deg = 0;  ///< from the nose, clockwise seen from above
    int spin = 0;          ///< as Rotor::spin; 0: either
    int level = 0;         ///< 1 above another rotor, -1 below one, 0 alone
  };

  std::string name;
  std::optional<int> px4_airframe;  ///< SYS_AUTOSTART
  std::optional<ArduPilot> ardupilot;
  std::vector<Place> rotors;

  /// Whether the vehicle's rotors have these directions, spins and levels, in this order.
  bool fits(const Vehicle& vehicle) const;
};

/// Reads the table. @throws ConfigError
CAS_BASE_EXPORT std::vector<Frame> load_frames(const std::filesystem::path& file);

}  // namespace cas::base

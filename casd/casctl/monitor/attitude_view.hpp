// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// Attitude of the body against the local frame, in degrees.
struct Attitude {
  double roll_deg = 0, pitch_deg = 0, yaw_deg = 0;
};

/// A position in the local frame N, m.
struct Place {
  double north_m = 0, east_m = 0;
};

/// Degrees of elevation for one line of horizon().
double degrees_a_line(std::size_t rows);

/// View of a camera in the nose: sky above, ground below, the aircraft's mark in the middle. A roll
/// to the right lifts the right side of the ground.
Block horizon(const Attitude& attitude, std::size_t width, std::size_t rows, bool unicode);

/// The headings around the present one, north 000, with a mark below it: two lines.
Block heading_tape(double yaw_deg, std::size_t width, bool unicode);

/// From above, north up: the trail, the origin of the frame as `+`, and the vehicle as an arrow
/// along its heading. The ends of the axes are in metres; the lower one is the last of `rows`.
Block top_view(const std::deque<Place>& trail, std::optional<double> yaw_deg, std::size_t width,
               std::size_t rows, bool unicode);

}  // namespace cas::casctl

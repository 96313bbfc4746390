// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "libsim/api/terrain_source.hpp"
#include "mavlink/common/terrain_data.hpp"
#include "mavlink/common/terrain_request.hpp"

namespace cas::sim {

/// Answers an autopilot's TERRAIN_REQUEST from the world's terrain.
///
/// A request names a block of 8 x 7 grids of 4 x 4 heights by its south-west corner, and by a mask
/// the grids that the autopilot lacks: bit 8 n + e is the n-th to the north and e-th to the east.
/// Each grid is one TERRAIN_DATA; they go out 20 ms apart, so that a serial line has room for the
/// rest. A further request takes the place of the one before.
class TerrainRequests {
 public:
  void take(const mavlink::common::TerrainRequest& request) { request_ = request; }
  /// The next grid, if one is due.
  std::optional<mavlink::common::TerrainData> next(base::SimTime now,
                                                   const TerrainSource::Elevation& elevation_m);

 private:
  std::optional<mavlink::common::TerrainRequest> request_;
  base::SimTime due_{};  // of the next grid
};

}  // namespace cas::sim

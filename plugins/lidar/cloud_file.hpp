// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/config/sensor_sheets.hpp"
#include "plugins/lidar/lidar_model.hpp"

namespace cas::sim {

/// A scan as a file: binary, little-endian, of a point x, y, z (m, in S when its beam fired),
/// intensity (cosine of the angle of incidence), t (s since the scan began) and ring.
///
/// PCD names where S was when the scan began, in W, as its viewpoint; PLY has it in a comment.
/// @param form  not kPgm
std::string cloud_text(const LidarScan& scan, base::CloudForm form);

/// A scan of a depth camera as a picture (PGM of 16 bits): depth along the axis in mm, 65535 beyond
/// 65.535 m, 0 without a return. A comment has the viewpoint as in a cloud.
std::string depth_text(const LidarScan& scan, const DepthPicture& picture);

}  // namespace cas::sim

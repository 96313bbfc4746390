// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace cas::hils {

/// Sample of the simulated gyro: rates about forward, right and down.
struct GyroSample {
  std::int64_t time_us = 0;
  std::array<double, 3> rate_rad_s{};
};

/// imu.csv as the recorder plugin writes it. Empty where the run recorded none.
/// @throws base::ConfigError naming file and line
std::vector<GyroSample> read_gyro(const std::filesystem::path& file);

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace cas::sim::test {

/// Writes an HGT file of n x n samples.
/// @param height_m  of latitude and longitude, degrees; rounded to whole metres
template <class Height>
void write_hgt(const std::filesystem::path& file, int n, double south, double west,
               Height height_m) {
  std::string bytes;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const double lat = south + 1 - static_cast<double>(row) / (n - 1);
      const double lon = west + static_cast<double>(column) / (n - 1);
      const auto height = static_cast<std::int16_t>(std::lround(height_m(lat, lon)));
      bytes += static_cast<char>(static_cast<std::uint16_t>(height) >> 8U);
      bytes += static_cast<char>(height & 0xff);
    }
  }
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace cas::sim::test

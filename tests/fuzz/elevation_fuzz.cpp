// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as an elevation file, GeoTIFF where they begin as one, else HGT: a height is a height
// on Earth, or there is none.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "libsim/core/terrain/elevation_file.hpp"
#include "libsim/core/terrain/elevation_map.hpp"
#include "tests/support/temporary_folder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const cas::test::TemporaryFolder folder;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const bool is_tiff = bytes.starts_with("II") || bytes.starts_with("MM");
  const auto file = folder.write(is_tiff ? "e.tif" : "N47E008.hgt", bytes);
  try {
    const cas::sim::ElevationGrid grid = cas::sim::open_elevation_file(file)->grid();
    const cas::sim::ElevationMap map(std::vector{file});
    for (const double down : {0.0, 0.5, 1.0}) {
      for (const double right : {0.0, 0.5, 1.0}) {
        const double lat = grid.north_deg - down * (grid.rows - 1) * grid.step_lat_deg;
        const double lon = grid.west_deg + right * (grid.columns - 1) * grid.step_lon_deg;
        const std::optional<double> height = map.height_m(lat, lon);
        if (height && !(std::abs(*height) < 40'000)) std::abort();
      }
    }
  } catch (const cas::base::ConfigError& error) {
    if (!std::string_view(error.what()).starts_with(file.string() + ": ")) std::abort();
  }
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "libsim/core/export.hpp"

namespace cas::sim {

/// Where the samples of a raster lie: rows from north to south, columns from west to east.
struct ElevationGrid {
  double west_deg = 0;   ///< longitude of the first column's samples
  double north_deg = 0;  ///< latitude of the first row's samples
  double step_lon_deg = 0;
  double step_lat_deg = 0;
  int columns = 0;
  int rows = 0;
  int block_columns = 0;  ///< of a piece that is read at once
  int block_rows = 0;
};

/// Most samples of one block: 64 MB.
inline constexpr int kMostBlockSamples = 1 << 24;

/// A raster of heights by latitude and longitude. The file is open only while it is read, so that
/// thousands of them take no descriptors.
class ElevationFile {
 public:
  explicit ElevationFile(const ElevationGrid& grid) : grid_(grid) {}
  virtual ~ElevationFile() = default;
  const ElevationGrid& grid() const { return grid_; }
  /// Reads one block.
  /// @param out  block_columns x block_rows heights, m; NaN without data. What lies beyond the
  ///             raster's edge is undefined
  /// @throws base::ConfigError when the file is cut, or has changed
  virtual void read_block(int column, int row, std::span<float> out) const = 0;

 protected:
  ElevationGrid grid_;
};

/// Whether the name is that of an elevation file: .hgt, .tif or .tiff.
bool is_elevation_file(const std::filesystem::path& file);

/// Opens an HGT file of the SRTM (its name is its south-west corner, N47E008.hgt) or a GeoTIFF of
/// one band in degrees.
/// @throws base::ConfigError when it is no such file, and for a GeoTIFF where CAS was built without
/// libtiff
CAS_SIM_EXPORT std::unique_ptr<ElevationFile> open_elevation_file(
    const std::filesystem::path& file);

/// The same of an HGT file: big-endian whole metres, -32768 without data, in a square whose outer
/// samples lie on full degrees.
std::unique_ptr<ElevationFile> open_hgt(const std::filesystem::path& file);

/// Entry point of libcas_sim_terrain.so: opens a GeoTIFF. libtiff has a library of its own, because
/// only worlds with such files need it. @throws base::ConfigError
extern "C" CAS_SIM_EXPORT void cas_open_geotiff(const std::filesystem::path& file,
                                                std::unique_ptr<ElevationFile>& out);

/// Symbol of cas_open_geotiff() in libcas_sim_terrain.so.
inline constexpr const char* kOpenGeotiff = "cas_open_geotiff";

}  // namespace cas::sim

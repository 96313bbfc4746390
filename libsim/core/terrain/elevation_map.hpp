// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "libsim/core/export.hpp"
#include "libsim/core/terrain/elevation_file.hpp"

namespace cas::sim {

/// Heights of many elevation files by latitude and longitude. Blocks of the files are read when
/// they are needed; the newest 64 MB of them stay in memory.
class CAS_SIM_EXPORT ElevationMap {
 public:
  /// @param paths  files, and folders of them
  /// @throws base::ConfigError for a path without such a file, and as open_elevation_file()
  explicit ElevationMap(std::span<const std::filesystem::path> paths);

  /// Height between samples by bilinear interpolation, m; of those of the finest file there. A
  /// sample without data counts as the mean of its neighbours in the cell.
  /// @return nullopt: no file has the place, or none of its samples has data
  /// @throws base::ConfigError when a file is cut, or has changed
  std::optional<double> height_m(double lat_deg, double lon_deg) const;
  /// Distance between samples at a place, degrees of latitude; nullopt: no file has it.
  std::optional<double> step_deg(double lat_deg, double lon_deg) const;
  std::size_t files() const { return files_.size(); }

 private:
  /// A place in the samples of a file: column and row, with a fraction.
  struct Spot {
    std::size_t file;
    double column;
    double row;
  };
  using BlockKey = std::uint64_t;
  struct Block {
    BlockKey key;
    std::vector<float> heights;
  };

  std::optional<Spot> spot_of(double lat_deg, double lon_deg) const;
  std::optional<Spot> spot_in(std::size_t file, double lat_deg, double lon_deg) const;
  double sample_near(const Spot& cell, int column, int row) const;
  double sample(std::size_t file, int column, int row) const;
  const Block& block(std::size_t file, int column, int row) const;

  std::vector<std::unique_ptr<ElevationFile>> files_;  // the finest first
  mutable std::size_t last_file_ = 0;                  // of spot_of()
  mutable std::list<Block> blocks_;                    // the newest first
  mutable std::unordered_map<BlockKey, std::list<Block>::iterator> by_key_;
  mutable std::size_t samples_ = 0;  // of the blocks
};

}  // namespace cas::sim

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>

namespace cas::hils {

/// Columns of truth.csv that not every vehicle has: they follow the motion.
struct TruthHeader {
  /// Column of rotor 1.
  static constexpr std::size_t kFirstRotor = 13;
  /// Columns of the wing before its surfaces.
  static constexpr std::size_t kWingColumns = 3;

  std::size_t rotors = 0;
  std::optional<std::size_t> airspeed{};  ///< column; of a vehicle with a pitot tube
  /// First column of those of a vehicle with a wing: angle of attack, sideslip, load factor.
  std::optional<std::size_t> wing{};
  std::size_t surfaces = 0;  ///< their deflections follow

  /// Least number of columns of a row: up to the last rotor, the airspeed and the wing.
  std::size_t columns() const;

  /// @param line  the first one of `file`
  /// @throws base::ConfigError when it is no header of truth.csv
  static TruthHeader parse(std::string_view line, const std::filesystem::path& file);
};

}  // namespace cas::hils

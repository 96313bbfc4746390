// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <optional>

namespace cas::hils {

/// Columns of truth.csv that not every vehicle has: they follow the motion.
struct TruthHeader {
  /// Column of rotor 1.
  static constexpr std::size_t kFirstRotor = 13;

  std::size_t rotors = 0;
  std::optional<std::size_t> airspeed{};  ///< column; of a vehicle with a pitot tube

  /// Reads the first line. @param file  its path, for errors
  /// @throws base::ConfigError when it is no header of truth.csv
  static TruthHeader read(std::istream& in, const std::filesystem::path& file);
};

}  // namespace cas::hils

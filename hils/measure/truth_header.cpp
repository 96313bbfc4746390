// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/truth_header.hpp"

#include <algorithm>

#include "base/config/vehicle.hpp"
#include "base/error.hpp"

namespace cas::hils {

std::size_t TruthHeader::columns() const {
  const std::size_t least = std::max(kFirstRotor + rotors, airspeed.value_or(0) + 1);
  return wing ? std::max(least, *wing + kWingColumns + surfaces) : least;
}

TruthHeader TruthHeader::parse(std::string_view line, const std::filesystem::path& file) {
  TruthHeader header;
  std::size_t column = 0;
  for (std::string_view rest = line; !rest.empty(); ++column) {
    const std::size_t comma = rest.find(',');
    const std::string_view name = rest.substr(0, comma);
    rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    if (column >= kFirstRotor && name.starts_with("omega")) ++header.rotors;
    if (name == "airspeed_m_s") header.airspeed = column;
    if (name == "alpha_rad") header.wing = column;
    if (header.wing && name.starts_with("deflection")) ++header.surfaces;
  }
  if (column <= kFirstRotor || header.rotors == 0 || header.rotors > base::kMaxRotors) {
    throw base::ConfigError(file.string() + ":1: not a header of truth.csv");
  }
  return header;
}

}  // namespace cas::hils

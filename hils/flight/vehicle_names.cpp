// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/vehicle_names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace cas::hils {

std::optional<std::size_t> parse_vehicle_key(const base::ConfigNode& node,
                                             const VehicleNames& names) {
  const std::optional<base::ConfigNode> key = node.find("vehicle");
  if (!key) return std::nullopt;
  const auto name = key->as<std::string>();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    key->fail(
        fmt::format("there is no vehicle '{}'; vehicles are {}", name, fmt::join(names, ", ")));
  }
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace cas::hils

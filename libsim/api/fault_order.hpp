// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

namespace cas::sim {

/// Topic of a vehicle on which plugin `fault` with `by_hand` takes FaultOrders.
inline constexpr std::string_view kFaultOrders = "fault_order";
/// The same for orders of ground stations, which plugin `mavlink_interface` takes in.
inline constexpr std::string_view kStationFaultOrders = "station_fault_order";

/// One more fault for a vehicle, ordered while it flies, or the end of one: it begins, or ends,
/// with the next step.
struct FaultOrder {
  static constexpr std::string_view kTypeName = "cas.FaultOrder";
  static constexpr unsigned kTypeVersion = 1;
  /// As an entry of the plugin's `faults`, in YAML or JSON, or {end: NAME}, which ends those of
  /// that name that were ordered; NUL-terminated.
  std::array<char, 1024> script{};
};

}  // namespace cas::sim

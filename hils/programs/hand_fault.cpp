// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/hand_fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/rpc/message.hpp"

namespace cas::hils {

using base::rpc::BadParams;
using base::rpc::CallError;

namespace {

constexpr double kSilent_s = 3;  // as the page's own bound

std::int64_t system_of(const nlohmann::json& value) {
  const bool is_whole = value.is_number_integer();
  const std::int64_t system = is_whole ? value.get<std::int64_t>() : 0;
  if (system >= 1 && system <= 255) return system;
  throw BadParams("vehicle is a whole number from 1 to 255");
}

}  // namespace

std::size_t vehicle_of_fault(const nlohmann::json& params, std::span<const std::uint8_t> systems,
                             std::span<const VehicleReport> vehicles) {
  const auto named = params.find("vehicle");
  const std::int64_t system = named == params.end() ? systems.front() : system_of(*named);
  const auto found = std::ranges::find(systems, system);
  if (found == systems.end()) {
    throw CallError(base::rpc::kNoSuchVehicle, fmt::format("there is no vehicle {}", system));
  }
  const auto i = static_cast<std::size_t>(found - systems.begin());
  if (!vehicles[i].hil) {
    throw CallError(
        base::rpc::kInterlock,
        fmt::format("vehicle {} does not say that it is in HIL: it gets no fault", system));
  }
  if (vehicles[i].heartbeat_age_s > kSilent_s) {
    throw CallError(base::rpc::kInterlock,
                    fmt::format("vehicle {} is silent, its last HEARTBEAT is {:.1f} s old: it "
                                "gets no fault",
                                system, vehicles[i].heartbeat_age_s));
  }
  return i;
}

}  // namespace cas::hils

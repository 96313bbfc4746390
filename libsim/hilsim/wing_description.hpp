// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>

#include "base/config/vehicle.hpp"
#include "libsim/core/load/model_loader.hpp"

namespace cas::sim {

/// Appends a line of a description.
template <class... Values>
void add_line(std::string& text, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
  text += '\n';
}

/// How a vehicle with wings flies, for `hilsim --describe`: its trim at `cruise_m_s` on the rotors
/// that push it forwards, at sea level; stall, best glide, and its modes about the trim, from the
/// models of plugins motor and aero.
std::string describe_wings(const base::Vehicle& vehicle, const VehicleModel& model);

}  // namespace cas::sim

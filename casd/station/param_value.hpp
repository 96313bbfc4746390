// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mavlink/common/enums.hpp"

namespace cas::casd {

/// How a vehicle puts an integer parameter into the float field of PARAM_SET and PARAM_VALUE.
enum class ParamEncoding {
  kBytewise,  ///< the integer's bytes (PX4)
  kCast,      ///< the number, converted (ArduPilot)
};

/// The number that a PARAM_VALUE carries.
double from_wire(ParamEncoding encoding, mavlink::common::MavParamType type, float wire);

/// The field of PARAM_SET for a number; nothing when the type cannot hold it (a fraction in an
/// integer, out of range, not finite).
std::optional<float> to_wire(ParamEncoding encoding, mavlink::common::MavParamType type,
                             double value);

/// Whether the vehicle's value is the one asked for, as far as the type can tell them apart.
bool same_value(mavlink::common::MavParamType type, double asked, double in_force);

/// "INT32", "REAL32", ...
std::string_view name(mavlink::common::MavParamType type);

/// Shortest decimal text that a float of this value reads back from: 0.15, not 0.150000006.
std::string number_text(double value);

}  // namespace cas::casd

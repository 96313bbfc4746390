// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

namespace cas::hils {

/// The number with `digits` after the point; a value that rounds to zero has no sign.
std::string fixed(double value, int digits);
/// The same, or a dash for nothing.
std::string fixed(const std::optional<double>& value, int digits);

}  // namespace cas::hils

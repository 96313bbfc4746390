// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

namespace cas::hils {

/// A series of numbers as a record has it: multiples of `step`, each as the difference from the one
/// before, which compresses well: {"k": 0.001, "d": [12, 1, 0, -1]}. A value that is no number
/// repeats the one before.
nlohmann::ordered_json column_json(std::span<const double> values, double step);

}  // namespace cas::hils

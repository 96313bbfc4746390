// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// How a raw field becomes a plain quantity: value = raw * factor / divisor, in `unit`.
struct Scale {
  std::string_view unit;        ///< end of the helper's name, e.g. `m_s`
  std::string factor, divisor;  ///< C++ literals
};

/// The scale of a scalar number field whose unit is not plain (`cm/s`, `degE7`, ...) or that has a
/// multiplier; nullopt for all others.
std::optional<Scale> scale_of(const xml::Field& field);

/// The XML attribute `invalid`.
struct Sentinel {
  enum class Extent { kScalar, kFirstElement, kAllElements };
  Extent extent{};
  bool is_nan{};
  std::string literal;  ///< C++ literal of the value, empty for NaN
};

/// The value for unknown, if the XML names one that the field's type can hold.
std::optional<Sentinel> sentinel_of(const xml::Field& field, const xml::Dialect& dialect);

}  // namespace cas::mav::gen

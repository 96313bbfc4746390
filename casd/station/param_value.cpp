// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/param_value.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

namespace cas::casd {
namespace {

using mavlink::common::MavParamType;

struct IntegerType {
  MavParamType type;
  double low;
  double high;
};

constexpr IntegerType kIntegers[] = {
    {MavParamType::kUint8, 0, 255},           {MavParamType::kInt8, -128, 127},
    {MavParamType::kUint16, 0, 65535},        {MavParamType::kInt16, -32768, 32767},
    {MavParamType::kUint32, 0, 4294967295.0}, {MavParamType::kInt32, -2147483648.0, 2147483647.0},
};

const IntegerType* integer(MavParamType type) {
  for (const IntegerType& entry : kIntegers) {
    if (entry.type == type) return &entry;
  }
  return nullptr;
}

/// The low bytes of the float field, read as the type they were written as.
double integer_from_bytes(MavParamType type, float wire) {
  const auto bits = std::bit_cast<std::uint32_t>(wire);
  switch (type) {
    case MavParamType::kUint8:
      return static_cast<std::uint8_t>(bits);
    case MavParamType::kInt8:
      return static_cast<std::int8_t>(bits);
    case MavParamType::kUint16:
      return static_cast<std::uint16_t>(bits);
    case MavParamType::kInt16:
      return static_cast<std::int16_t>(bits);
    case MavParamType::kUint32:
      return bits;
    default:
      return static_cast<std::int32_t>(bits);
  }
}

}  // namespace

double from_wire(ParamEncoding encoding, MavParamType type, float wire) {
  if (encoding == ParamEncoding::kCast || integer(type) == nullptr) return wire;
  return integer_from_bytes(type, wire);
}

std::optional<float> to_wire(ParamEncoding encoding, MavParamType type, double value) {
  if (!std::isfinite(value)) return std::nullopt;
  const IntegerType* range = integer(type);
  if (range == nullptr) {
    if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
      return std::nullopt;
    }
    return static_cast<float>(value);
  }
  if (value < range->low || value > range->high || value != std::floor(value)) {
    return std::nullopt;
  }
  if (encoding == ParamEncoding::kCast) return static_cast<float>(value);
  return std::bit_cast<float>(static_cast<std::uint32_t>(static_cast<std::int64_t>(value)));
}

bool same_value(MavParamType type, double asked, double in_force) {
  if (integer(type) != nullptr) return asked == in_force;
  return static_cast<float>(asked) == static_cast<float>(in_force);
}

std::string_view name(MavParamType type) {
  switch (type) {
    case MavParamType::kUint8:
      return "UINT8";
    case MavParamType::kInt8:
      return "INT8";
    case MavParamType::kUint16:
      return "UINT16";
    case MavParamType::kInt16:
      return "INT16";
    case MavParamType::kUint32:
      return "UINT32";
    case MavParamType::kInt32:
      return "INT32";
    case MavParamType::kReal32:
      return "REAL32";
    default:
      return "unknown";
  }
}

std::string number_text(double value) {
  char text[48];
  const bool whole = std::floor(value) == value && std::abs(value) < 1e15;
  const auto end = whole ? std::to_chars(text, text + sizeof text, value, std::chars_format::fixed)
                         : std::to_chars(text, text + sizeof text, static_cast<float>(value));
  return std::string(text, end.ptr);
}

}  // namespace cas::casd

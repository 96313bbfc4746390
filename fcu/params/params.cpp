// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/params/params.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "fcu/params/param_table.hpp"

namespace cas::fcu {

namespace {

double representable(ParamType type, double value) {
  if (type == ParamType::kInt32) return std::nearbyint(value);
  return static_cast<double>(static_cast<float>(value));
}

/// CRC-32 (polynomial 0xEDB88320, reflected, no inversion), one more byte.
std::uint32_t crc32_byte(std::uint32_t crc, std::uint8_t byte) {
  crc ^= byte;
  for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  return crc;
}

/// The parameters that `wanted` picks, as "NAME VALUE" lines.
std::string lines(const std::vector<Param>& params, bool (*wanted)(const Param&)) {
  constexpr int kDigits = 10;  // a float and an INT32 come back exactly
  std::ostringstream out;
  out.precision(kDigits);
  for (const Param& param : params) {
    if (wanted(param)) out << param.name << ' ' << param.value << '\n';
  }
  return out.str();
}

}  // namespace

ParamStore::ParamStore(const base::Vehicle& vehicle, const EstimatorParams& estimator,
                       double delay_s)
    : params_(default_params(vehicle, estimator, delay_s)) {
  for (Param& param : params_) {
    CAS_CHECK(param.name.size() <= 16);
    param.value = param.start = param.initial = representable(param.type, param.initial);
  }
  std::sort(params_.begin(), params_.end(),
            [](const Param& a, const Param& b) { return a.name < b.name; });
}

std::optional<std::size_t> ParamStore::index_of(std::string_view name) const {
  const auto place =
      std::lower_bound(params_.begin(), params_.end(), name,
                       [](const Param& param, std::string_view key) { return param.name < key; });
  if (place == params_.end() || place->name != name) return std::nullopt;
  return static_cast<std::size_t>(place - params_.begin());
}

double ParamStore::get(std::string_view name) const {
  const std::optional<std::size_t> index = index_of(name);
  CAS_CHECK(index.has_value());
  return params_[*index].value;
}

ParamSetResult ParamStore::set(std::string_view name, double value) {
  const std::optional<std::size_t> index = index_of(name);
  if (!index) return ParamSetResult::kUnknown;
  if (!std::isfinite(value)) return ParamSetResult::kNotANumber;
  Param& param = params_[*index];
  const double rounded = representable(param.type, value);
  // Bounds in the wire's precision: 0.1 as a float is a little above 0.1.
  if (rounded < representable(param.type, param.low) ||
      rounded > representable(param.type, param.high)) {
    return ParamSetResult::kOutOfRange;
  }
  if (rounded != param.value) {
    param.value = rounded;
    ++revision_;
  }
  return ParamSetResult::kOk;
}

void ParamStore::reset_to_defaults() {
  for (Param& param : params_) param.value = param.initial;
  ++revision_;
}

void ParamStore::mark_start() {
  for (Param& param : params_) param.start = param.value;
}

std::string ParamStore::changed_text() const {
  return lines(params_, [](const Param& param) { return param.value != param.start; });
}

std::string ParamStore::all_text() const {
  return lines(params_, [](const Param&) { return true; });
}

std::uint32_t ParamStore::hash() const {
  std::uint32_t crc = 0;
  for (const Param& param : params_) {
    for (const char c : param.name) crc = crc32_byte(crc, static_cast<std::uint8_t>(c));
    const auto bits = std::bit_cast<std::uint32_t>(to_wire(param));
    for (unsigned shift = 0; shift < 32; shift += 8) {
      crc = crc32_byte(crc, static_cast<std::uint8_t>(bits >> shift));
    }
  }
  return crc;
}

float ParamStore::to_wire(const Param& param) {
  if (param.type == ParamType::kReal32) return static_cast<float>(param.value);
  return std::bit_cast<float>(static_cast<std::int32_t>(param.value));
}

double ParamStore::from_wire(ParamType type, float field) {
  if (type == ParamType::kReal32) return static_cast<double>(field);
  return static_cast<double>(std::bit_cast<std::int32_t>(field));
}

}  // namespace cas::fcu

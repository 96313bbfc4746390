// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/config/config.hpp"

namespace cas::base {

/// A node's own number, which must lie in [low, high]. @throws ConfigError
CAS_BASE_EXPORT double number_in(const ConfigNode& node, double low, double high);
/// The same for a whole number. @throws ConfigError for a fraction too
CAS_BASE_EXPORT std::int64_t whole_in(const ConfigNode& node, std::int64_t low, std::int64_t high);
/// The shortest text that is read as the same number.
CAS_BASE_EXPORT std::string number_text(double value);

/// The whole number under a mandatory key, in [low, high]: the counterpart of
/// ConfigNode::require_in(). @throws ConfigError with file, line and key path for a fraction too
template <std::integral T>
T require_whole_in(const ConfigNode& node, std::string_view key, std::type_identity_t<T> low,
                   std::type_identity_t<T> high) {
  return static_cast<T>(
      whole_in(node.at(key), static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)));
}

/// The same for an optional key.
template <std::integral T>
T get_whole_in(const ConfigNode& node, std::string_view key, std::type_identity_t<T> fallback,
               std::type_identity_t<T> low, std::type_identity_t<T> high) {
  return node.has(key) ? require_whole_in<T>(node, key, low, high) : fallback;
}

}  // namespace cas::base

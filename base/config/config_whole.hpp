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

/// The whole number under a mandatory key, in [low, high]: what ConfigNode::require_in() is for
/// numbers. @throws ConfigError with file, line and key path for a fraction too
template <std::integral T>
T require_whole_in(const ConfigNode& node, std::string_view key, std::type_identity_t<T> low,
                   std::type_identity_t<T> high) {
  const ConfigNode child = node.at(key);
  const auto value = child.as<std::int64_t>();
  if (value < static_cast<std::int64_t>(low) || value > static_cast<std::int64_t>(high)) {
    child.fail(std::to_string(value) + " must lie in [" + std::to_string(low) + ", " +
               std::to_string(high) + "]");
  }
  return static_cast<T>(value);
}

/// Likewise, of an optional key.
template <std::integral T>
T get_whole_in(const ConfigNode& node, std::string_view key, std::type_identity_t<T> fallback,
               std::type_identity_t<T> low, std::type_identity_t<T> high) {
  return node.has(key) ? require_whole_in<T>(node, key, low, high) : fallback;
}

}  // namespace cas::base

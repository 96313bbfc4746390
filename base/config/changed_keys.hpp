// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include "base/config/config_keys.hpp"

namespace cas::base {

/// The keys of a list whose value is not the default, each with its value, "queue.hil_max_age_ms
/// 64"; those of blocks by their path. Keys that their owner reads (ReadApart) are left out.
/// @param standard  a struct as it is before it is read
template <class Keys, class Struct>
void add_changed_keys(const Keys& keys, const Struct& given, const Struct& standard,
                      std::vector<std::string>& changed, const std::string& prefix = "") {
  const auto add = [&](const std::string& path, const std::string& now, const std::string& usual) {
    if (now != usual) changed.push_back(path + " " + now);
  };
  for_each_key(keys, [&](const auto& key) {
    using Kind = typename std::decay_t<decltype(key)>::Kind;
    const auto& value = key.of(given);
    const auto& usual = key.of(standard);
    const std::string path = prefix + std::string(key.name);
    if constexpr (requires { key.kind.keys; }) {
      using Inner = typename Kind::Struct;
      if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Inner>) {
        add_changed_keys(key.kind.keys, value, usual, changed, path + ".");
      } else if (value) {
        const std::size_t before = changed.size();
        add_changed_keys(key.kind.keys, *value, usual.value_or(Inner{}), changed, path + ".");
        if (!usual && changed.size() == before) changed.push_back(path);
      }
    } else if constexpr (requires { key.kind.text(value); }) {
      add(path, key.kind.text(value), key.kind.text(usual));
    } else if constexpr (requires { key.kind.text(*value); }) {
      add(path, value ? key.kind.text(*value) : "none", usual ? key.kind.text(*usual) : "none");
    }
  });
}

}  // namespace cas::base

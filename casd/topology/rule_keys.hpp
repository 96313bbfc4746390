// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/config/config_keys.hpp"
#include "casd/routing/routing_rules.hpp"
#include "casd/topology/message_keys.hpp"

namespace cas::casd {

inline constexpr std::tuple kRateKeys{
    base::key<&RateRule::max_hz>("max_hz", base::Range{0, 1e6},
                                 "packets a second that pass; 0: any"),
    base::key<&RateRule::every>("every", base::Whole{1, 1'000'000}, "each n-th passes"),
};

/// message -> `max_hz`, or a block.
struct RatesOf : base::Block<RateRule, decltype(kRateKeys)> {
  void read(const base::ConfigNode& node, std::vector<RateRule>& rates) const {
    for (const auto& [message, entry] : node.entries()) {
      RateRule& rate = rates.emplace_back(RateRule{.message_id = parse_message(entry, message)});
      if (entry.is_map()) {
        Block::read(entry, rate);
      } else {
        rate.max_hz = entry.as<double>();
      }
      if (rate.max_hz <= 0 && rate.every == 1) {
        entry.fail("needs max_hz above 0, or every above 1");
      }
    }
  }
  static std::string text(const std::vector<RateRule>& rates) {
    return joined(rates, [](const RateRule& rate) { return message_word(rate.message_id); });
  }
  static std::string values() { return "message -> `max_hz`, or a block"; }
  static std::array<std::string, 2> samples() { return {"{HEARTBEAT: 1}", "{HEARTBEAT: 2}"}; }
};

/// A key with the words that stand before its value in `casd --check`.
template <class Key>
struct Worded : Key {
  std::string_view words;
};
template <class Key>
constexpr Worded<Key> worded(std::string_view words, const Key& key) {
  return {key, words};
}

inline constexpr std::tuple kRuleKeys{
    worded("only",
           base::key<&ForwardRule::allow>("allow", Messages{}, "these messages alone", "all")),
    worded("not", base::key<&ForwardRule::block>("block", Messages{}, "not these messages")),
    worded("only systems",
           base::key<&ForwardRule::allow_systems>("allow_systems", Ids{},
                                                  "these systems (of the sender) alone", "all")),
    worded("not systems",
           base::key<&ForwardRule::block_systems>("block_systems", Ids{}, "not these systems")),
    worded("only components",
           base::key<&ForwardRule::allow_components>(
               "allow_components", Ids{}, "these components (of the sender) alone", "all")),
    worded("not components", base::key<&ForwardRule::block_components>("block_components", Ids{},
                                                                       "not these components")),
    worded("thinned out",
           base::key<&ForwardRule::rates>("rates", RatesOf{{kRateKeys}}, "thins messages out")),
};

/// Calls visit(key, list) for each filter that a rule has. An empty `allow` lets nothing pass.
template <class Visit>
void for_each_filter(const ForwardRule& rule, Visit&& visit) {
  base::for_each_key(kRuleKeys, [&](const auto& key) {
    const auto& value = key.of(rule);
    if constexpr (requires { *value; }) {
      if (value) visit(key, *value);
    } else if (!value.empty()) {
      visit(key, value);
    }
  });
}

}  // namespace cas::casd

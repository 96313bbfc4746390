// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/router_filters.hpp"

#include <string_view>

#include "base/text.hpp"
#include "casd/topology/endpoint_notation.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

std::string word(std::uint32_t id, bool messages) {
  const mav::MessageInfo* known = messages ? mav::public_table().find(id) : nullptr;
  return known == nullptr ? std::to_string(id) : std::string(known->name);
}

RouterConfig::Ids simulator_messages() {
  RouterConfig::Ids ids;
  for (const std::string_view name : kSimulatorMessages)
    ids.insert(mav::public_table().find(name)->id);
  return ids;
}

}  // namespace

std::string id_list(const char* key, const RouterConfig::Ids& list, bool messages) {
  const auto word_of = [messages](std::uint32_t id) { return word(id, messages); };
  return std::string(key) + ": [" + base::joined(list, ", ", word_of) + "]";
}

std::string rule_between(const RouterFilters& from, const RouterFilters& to) {
  std::string text;
  const auto add = [&](const char* key, const RouterConfig::Ids& list, bool messages) {
    if (!list.empty()) text += ", " + id_list(key, list, messages);
  };
  const auto both = [](RouterConfig::Ids one, RouterConfig::Ids other) {
    one.merge(other);
    return one;
  };
  add("allow", to.allow_messages_out, true);
  RouterConfig::Ids block = both(from.block_messages_in, to.block_messages_out);
  if (to.allow_messages_out.empty()) block.merge(simulator_messages());
  add("block", block, true);
  add("allow_systems", to.allow_systems_out, false);
  add("block_systems", to.block_systems_out, false);
  RouterConfig::Ids components = both(from.allow_components_in, to.allow_components_out);
  if (!from.allow_components_in.empty() && !to.allow_components_out.empty()) {
    std::erase_if(components, [&](std::uint32_t id) {
      return !from.allow_components_in.contains(id) || !to.allow_components_out.contains(id);
    });
    if (components.empty()) return ", allow: []";  // an empty list of components is all
  }
  add("allow_components", components, false);
  add("block_components", both(from.block_components_in, to.block_components_out), false);
  return text;
}

}  // namespace cas::casd

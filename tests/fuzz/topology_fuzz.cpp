// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a topology: a ConfigError or a topology of which plan and budget can be made.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.hpp"
#include "casd/topology/line_budget.hpp"
#include "casd/topology/routing_plan.hpp"
#include "casd/topology/topology.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cas;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const auto topology = casd::Topology::parse(base::ConfigNode::parse(text));
    const casd::LinkSlots slots = casd::slots_in_order(topology);
    if (topology.links.empty() || slots.size() != topology.links.size()) std::abort();
    for (const auto& [name, slot] : slots) {
      if (slot == casd::kLocalLink || slot >= casd::kLinkSlots) std::abort();
    }
    if (casd::make_plan(topology, slots) == nullptr) std::abort();
    for (const casd::LineBudget& budget : casd::line_budgets(topology)) {
      if (!slots.contains(budget.link)) std::abort();
    }
    casd::line_budget_warnings(topology);
  } catch (const base::ConfigError&) {
  }
  return 0;
}

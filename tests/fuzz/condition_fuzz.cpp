// SPDX-License-Identifier: BSD-3-Clause
// Any text as a condition: a refusal, or an expression that can be evaluated.
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "plugins/fault/expression.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cas::sim;
  try {
    const Expression condition = Expression::parse({reinterpret_cast<const char*>(data), size});
    Facts facts;
    condition.evaluate(facts);
    for (double& value : facts.values) value = 1;
    facts.phase = "hold";
    condition.evaluate(facts);
    condition.phases();
  } catch (const std::invalid_argument&) {
  }
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_facts.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "base/angles.hpp"

namespace cas::hils {

sim::Facts facts_of(base::SimTime now, const Motion& motion, bool armed, std::string_view phase) {
  using sim::Fact;
  sim::Facts facts;
  facts[Fact::kTime] = base::to_seconds(now);
  facts[Fact::kNorth] = motion.p_m.x();
  facts[Fact::kEast] = motion.p_m.y();
  facts[Fact::kAltitude] = motion.p_m.z();
  facts[Fact::kHeight] = motion.p_m.z();  // level ground
  facts[Fact::kSpeed] = motion.v_m_s.norm();
  facts[Fact::kClimb] = motion.v_m_s.z();
  facts[Fact::kRoll] = motion.rpy_rad.x() * base::kDegPerRad;
  facts[Fact::kPitch] = motion.rpy_rad.y() * base::kDegPerRad;
  facts[Fact::kYaw] = motion.rpy_rad.z() * base::kDegPerRad;
  facts[Fact::kArmed] = armed ? 1 : 0;
  facts.phase = phase;
  return facts;
}

std::optional<Condition> parse_condition(const base::ConfigNode& node, std::string_view key) {
  const std::optional<base::ConfigNode> child = node.find(key);
  const auto of = node.get<std::string>("of", "estimate");
  if (of != "estimate" && of != "truth") node.at("of").fail("is estimate or truth");
  if (!child) return std::nullopt;
  try {
    return Condition{.expression = sim::Expression::parse(child->as<std::string>()),
                     .on_truth = of == "truth"};
  } catch (const std::invalid_argument& error) {
    child->fail(error.what());
  }
}

}  // namespace cas::hils

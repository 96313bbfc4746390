// SPDX-License-Identifier: BSD-3-Clause
#include "hils/scenario/scenario_limits.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace cas::hils {

namespace {

constexpr std::array<std::string_view, 4> kAxes{"x_m", "y_m", "z_m", "yaw_rad"};

std::map<std::string, double> parse_axes(const base::ConfigNode& limits, std::string_view key) {
  std::map<std::string, double> axes;
  const std::optional<base::ConfigNode> node = limits.find(key);
  if (!node) return axes;
  for (const std::string_view axis : kAxes) {
    if (node->has(axis)) axes[std::string(axis)] = node->require_in(axis, 0, 1e6);
  }
  return axes;
}

std::optional<double> optional_limit(const base::ConfigNode& node, std::string_view key,
                                     double most) {
  if (!node.has(key)) return std::nullopt;
  return node.require_in(key, 0, most);
}

bool has_response(const std::vector<FlightStep>& steps, std::string_view name) {
  return std::ranges::any_of(steps, [name](const FlightStep& step) {
    return step.trajectory.shape == fcu::PatternShape::kSteps && phase_of(step) == name;
  });
}

/// Each key is the name of a `trajectory: {shape: step}` of the flight.
std::map<std::string, ResponseLimits> parse_responses(const base::ConfigNode& limits,
                                                      const std::vector<FlightStep>& steps) {
  std::map<std::string, ResponseLimits> responses;
  const std::optional<base::ConfigNode> node = limits.find("responses");
  if (!node) return responses;
  for (const auto& [name, body] : node->entries()) {
    if (!has_response(steps, name))
      body.fail("the flight has no 'trajectory: {shape: step}' of that name");
    responses[name] = {.rise_s = optional_limit(body, "rise_s", 1e6),
                       .overshoot_pct = optional_limit(body, "overshoot_pct", 1e6),
                       .settling_s = optional_limit(body, "settling_s", 1e6)};
  }
  return responses;
}

}  // namespace

Limits parse_limits(const base::ConfigNode& node, const std::vector<FlightStep>& steps) {
  Limits limits;
  limits.delivered_pct = optional_limit(node, "delivered_pct", 100);
  limits.responses = parse_responses(node, steps);
  if (node.has("lost")) limits.lost = node.require<std::uint64_t>("lost");
  if (node.has("rate_error_pct")) limits.rate_error_pct = node.require_in("rate_error_pct", 0, 100);
  if (node.has("latency_p99_us")) limits.latency_p99_us = node.require_in("latency_p99_us", 0, 1e9);
  limits.rms = parse_axes(node, "rms");
  limits.rms_estimate = parse_axes(node, "rms_estimate");
  return limits;
}

Limits limits_for(std::size_t vehicle, Limits limits, const std::vector<FlightStep>& steps) {
  const std::vector<FlightStep> own = steps_for(vehicle, steps);
  std::erase_if(limits.responses,
                [&own](const auto& response) { return !has_response(own, response.first); });
  return limits;
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/fleet_plan.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace cas::hils {

namespace {

/// The report of a vehicle that waits with its arming for what it or another one lacks.
VehicleReport waiting_for(const std::string& lack, VehicleReport vehicle) {
  if (!vehicle.position_lack) vehicle.position_lack = lack;
  return vehicle;
}

}  // namespace

FleetPlan::FleetPlan(VehicleNames names, const std::vector<FlightStep>& steps,
                     std::span<const double> start_yaw_rad, FirmwareHabits habits)
    : names_(std::move(names)) {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    plans_.emplace_back(steps_for(i, steps), start_yaw_rad[i], habits);
  }
}

/// The end of one vehicle's step may let another go on: repeat until nothing more ends now.
std::vector<FleetPlan::Command> FleetPlan::update(base::SimTime now,
                                                  std::span<const VehicleReport> vehicles) {
  std::vector<Command> commands;
  const std::optional<std::string> lack = lack_before_arming(vehicles);
  std::size_t before = 0;
  do {
    before = progress();
    for (std::size_t i = 0; i < plans_.size(); ++i) {
      const auto look = [&](const VehicleReport& vehicle) {
        return plans_[i].update(now, vehicle, others_through(i));
      };
      std::optional<FlightStep> step =
          lack ? look(waiting_for(*lack, vehicles[i])) : look(vehicles[i]);
      if (step) commands.push_back({.vehicle = i, .step = std::move(*step)});
    }
  } while (plans_.size() > 1 && progress() != before);
  return commands;
}

/// What one of several vehicles lacks for its arming: the others wait for it, because a stock
/// firmware that has been armed disarms itself after a while.
std::optional<std::string> FleetPlan::lack_before_arming(
    std::span<const VehicleReport> vehicles) const {
  for (std::size_t i = 0; i < plans_.size() && plans_.size() > 1; ++i) {
    const FlightStep* const step = plans_[i].current();
    const bool arms = step != nullptr && step->kind == StepKind::kArm;
    if (arms && vehicles[i].position_lack) return names_[i] + ": " + *vehicles[i].position_lack;
  }
  return std::nullopt;
}

void FleetPlan::on_outcome(std::size_t vehicle, base::SimTime now,
                           const std::optional<Refusal>& refusal) {
  plans_[vehicle].on_outcome(now, refusal);
}

bool FleetPlan::ended() const {
  return std::ranges::all_of(plans_, &FlightPlan::done) ||
         std::ranges::any_of(plans_, [](const auto& plan) { return plan.failure().has_value(); });
}

std::size_t FleetPlan::leader() const {
  const std::size_t step = plans_[slowest()].completed();
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].completed() == step && !plans_[i].stands_by()) return i;
  }
  return 0;
}

std::optional<std::string> FleetPlan::failure_of(std::size_t vehicle) const {
  if (plans_[vehicle].failure()) return plans_[vehicle].failure();
  const auto failed = std::ranges::find_if(
      plans_, [](const FlightPlan& plan) { return plan.failure().has_value(); });
  if (failed == plans_.end()) return std::nullopt;
  return "it ended with that of " + names_[static_cast<std::size_t>(failed - plans_.begin())];
}

std::size_t FleetPlan::slowest() const {
  const auto least = std::ranges::min_element(plans_, {}, &FlightPlan::completed);
  return static_cast<std::size_t>(least - plans_.begin());
}

std::size_t FleetPlan::others_through(std::size_t vehicle) const {
  std::size_t least = FlightPlan::kNobody;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (i != vehicle) least = std::min(least, plans_[i].through());
  }
  return least;
}

std::size_t FleetPlan::progress() const {
  std::size_t sum = 0;
  for (const FlightPlan& plan : plans_) sum += 2 * plan.completed() + (plan.begun() ? 1 : 0);
  return sum;
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_reboot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hils/flight/flight_plan.hpp"

namespace cas::hils {
namespace {

/// PX4 (v1.12.0) writes changed parameters to its file 0.3 s later, and at most every 2 s.
constexpr base::Duration kStores = std::chrono::seconds(5);
/// MAVLink carries parameters as float.
constexpr double kFloatRounding = 1e-6;

bool is_same(double a, double b) {
  return std::abs(a - b) <= kFloatRounding * std::max(1.0, std::abs(a));
}

}  // namespace

WrittenParams written_params(std::span<const Stage> stages) {
  WrittenParams written;
  for (const Stage& stage : stages) {
    if (stage.step.kind != StepKind::kSetParam) continue;
    for (const auto& param : stage.step.params) {
      std::erase_if(written, [&](const auto& older) { return older.first == param.first; });
      written.push_back(param);
    }
  }
  return written;
}

std::optional<std::string> FirmwareReboot::run(const WrittenParams& written,
                                               base::SimTime written_at,
                                               base::Duration patience) const {
  const base::RunTime deadline = base::steady_now() + patience;
  while (!written.empty() && look() < written_at + kStores) {
    if (base::steady_now() > deadline) return "simulated time stands still before the reboot";
    wait(FlightPlan::kLookPeriod);
  }
  restart();
  if (auto fault = wait_until_heard(deadline)) return fault;
  return compare(written, deadline);
}

std::optional<std::string> FirmwareReboot::wait_until_heard(base::RunTime deadline) const {
  wait(FlightPlan::kLookPeriod);  // now all HEARTBEATs of the old program are counted
  for (const double before = heartbeats(); heartbeats() <= before; wait(FlightPlan::kLookPeriod)) {
    if (base::steady_now() > deadline) {
      return "the firmware was not heard again after its reboot; its log in the run folder of the "
             "results has what it says";
    }
  }
  return std::nullopt;
}

std::optional<std::string> FirmwareReboot::compare(const WrittenParams& written,
                                                   base::RunTime deadline) const {
  for (const auto& [name, value] : written) {
    std::optional<double> now = parameter(name);
    for (; !now && base::steady_now() < deadline; now = parameter(name))
      wait(FlightPlan::kLookPeriod);
    if (!now) return fmt::format("the firmware did not tell {} after its reboot", name);
    if (!is_same(value, *now)) {
      return fmt::format("the reboot has lost a parameter: {} was set to {:g}, and is {:g}", name,
                         value, *now);
    }
  }
  return std::nullopt;
}

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"
#include "plugins/fault/expression.hpp"

namespace cas::sim {

enum class SensorTopic : std::uint8_t { kImu, kGps, kMagnetometer, kBarometer, kRangefinder };

/// The part of a sample that a fault changes.
enum class SampleField : std::uint8_t {
  kSpecificForce,
  kAngularRate,
  kPosition,  ///< north, east, down
  kVelocity,
  kField,
  kPressure,
  kTemperature,
  kDistance,
};

enum class SensorEffect : std::uint8_t { kFreeze, kDrop, kDelay, kBias, kScale, kNoise };

struct SensorFault {
  SensorTopic topic{};
  SensorEffect effect{};
  SampleField field{};
  Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< SI; factor for kScale, deviation for kNoise
  base::Duration delay{};
};

struct RotorFault {
  int rotor = 0;  ///< 0..3
  double speed_share = 1;
  double thrust_share = 1;
};

struct VoltageFault {
  double share = 1;
};

struct MassFault {
  double factor = 1;
};

struct CgFault {
  Eigen::Vector3d shift_B_m = Eigen::Vector3d::Zero();
};

using FaultKind =
    std::variant<SensorFault, RotorFault, VoltageFault, MassFault, CgFault, GustCommand>;

/// One fault: when it begins, how long it lasts, what it does.
struct FaultSpec {
  std::string name;
  std::optional<base::SimTime> at;
  std::optional<Expression> when;
  std::optional<base::Duration> lasting;  ///< neither lasting nor until: to the end of the run
  std::optional<Expression> until;
  FaultKind kind;
};

/// Reads one fault. @param number  names it where it has no name, from 1
FaultSpec parse_fault(const base::ConfigNode& node, std::size_t number);
/// Reads the list `faults` of plugin `fault`: keys are described in docs/plugins.md.
std::vector<FaultSpec> parse_faults(const base::ConfigNode& node);

}  // namespace cas::sim

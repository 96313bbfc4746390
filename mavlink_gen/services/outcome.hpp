// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mavlink/common/enums.hpp"

namespace cas::mav::services {

/// How a request to a vehicle ended.
enum class OutcomeKind {
  kAccepted,       ///< the vehicle acknowledged, or the value asked for is in force
  kRefused,        ///< the vehicle said no, or keeps another value
  kTimeout,        ///< no answer after all tries
  kNoSuchVehicle,  ///< nothing of that system id has been heard
  kInterlock,      ///< the vehicle does not say that it is in HIL
  kInvalid,        ///< the request makes no sense for this vehicle
};

/// How a request ended, in a form for programs and for people.
struct Outcome {
  OutcomeKind kind = OutcomeKind::kAccepted;
  std::string message;                               ///< a sentence; empty when accepted
  std::optional<mavlink::common::MavResult> result;  ///< of the last COMMAND_ACK
  std::vector<std::string> status_texts;             ///< the vehicle's texts meanwhile
  std::map<std::string, double> parameters;          ///< values in force, by name
  std::map<std::string, double> before;  ///< of those that were set: the value until then

  bool ok() const { return kind == OutcomeKind::kAccepted; }
};

inline Outcome failure(OutcomeKind kind, std::string message) {
  Outcome outcome;
  outcome.kind = kind;
  outcome.message = std::move(message);
  return outcome;
}

/// Called once, when the request has ended.
using Done = std::function<void(const Outcome&)>;

}  // namespace cas::mav::services

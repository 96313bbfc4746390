// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "casd/casctl/monitor/monitor_state.hpp"
#include "casd/casctl/monitor/prompt.hpp"
#include "casd/casctl/session/session.hpp"

namespace cas::casctl {

/// Messages that are asked for: more than anybody scrolls through, those that were heard first.
inline constexpr int kMostRows = 2000;

// The monitor's queries of casd, each function over a connection of its own, so that it may run
// beside the screen. None throws: the answer holds the error.

/// Seconds of the steady clock.
double now_s();

/// One query of casd, and its answers.
struct Look {
  std::optional<int> vehicle;      ///< system id; nullopt: the first one
  std::optional<MessageKey> open;  ///< whose values are wanted
  nlohmann::json status, messages, state, telemetry, value;
  std::optional<std::string> fault;  ///< why casd did not answer; nullopt: it did
  double time_s = 0;
};

/// Asks casd over `session`, which it makes again when it is gone.
Look take_look(std::unique_ptr<Session>& session, const Options& options, Look look);

/// The gains of all loops, or a sentence.
struct GainsAnswer {
  nlohmann::json gains = nlohmann::json::array();
  std::optional<std::string> fault;
};

GainsAnswer ask_gains(const Options& options);

/// Names of all parameters; none if the vehicle does not list them.
std::vector<std::string> ask_parameters(const Options& options);

/// The answer to a command, and whether it was done.
using CommandAnswer = std::pair<std::string, bool>;

/// @param line  as it was typed; the answer begins with it
CommandAnswer run_command(const Options& options, const std::string& line, const PromptCall& call);

}  // namespace cas::casctl

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "casd/casctl/session/command_line.hpp"

namespace cas::casctl {

/// A method call that a line of the prompt stands for: "takeoff 3", "setgain roll 6.5".
struct PromptCall {
  std::string method;
  nlohmann::json params = nlohmann::json::object();
};
/// @return the call, or a sentence that says what is wrong
std::variant<PromptCall, std::string> parse_prompt(const std::string& line);

/// The verb `monitor`: the full screen, or with --once its figures as a table.
void add_monitor_verb(CommandLine& line);

}  // namespace cas::casctl

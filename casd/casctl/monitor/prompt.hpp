// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "base/cli/command_tree.hpp"

namespace cas::casctl {

/// The method call of a line of the prompt: "takeoff 3", "setgain roll 6.5".
struct PromptCall {
  std::string method;
  nlohmann::json params = nlohmann::json::object();
  bool of_vehicle = true;  ///< else of casd itself
};
/// @return the call, or an error sentence
std::variant<PromptCall, std::string> parse_prompt(const std::string& line);

/// Result of a call, in a few words: "roll: P 6.4 -> 6.5", "done".
std::string answer_text(const PromptCall& call, const nlohmann::json& result);

/// The words that completion offers as a verb's first argument.
struct PromptWords {
  base::cli::WordsByCommand by_verb;    ///< the table of casctl's own completion
  std::vector<std::string> messages;    ///< that casd hears
  std::vector<std::string> parameters;  ///< of the vehicle; empty until they have been asked for
};

/// Completion of a prompt line by the Tab key: the longer line, and the words on offer.
struct Completion {
  std::string line;                   ///< with the common prefix of all offers
  std::vector<std::string> offers{};  ///< words that may end the line
  std::string usage{};                ///< of the verb, once there is one: "takeoff ALT"
  bool wants_parameters = false;      ///< their names are not known yet
};
/// Completes the last word of a line; upper and lower case are the same to it.
Completion complete(const std::string& line, const PromptWords& words);

/// A line for each verb of the prompt, for the help: "takeoff ALT".
std::vector<std::string> prompt_usages();

}  // namespace cas::casctl

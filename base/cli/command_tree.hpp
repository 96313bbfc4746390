// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

namespace cas::base::cli {

/// One option, flag or argument.
struct Argument {
  std::vector<std::string> names;  ///< "-h", "--help"; for a positional only its word
  std::string value;               ///< its value's type, "TEXT"; empty for a flag
  std::string description;
  std::string fallback;     ///< default, as printed in the help
  std::string environment;  ///< environment variable in its place
  bool positional = false;
  bool required = false;
};

/// Words that shell completion offers for a verb's arguments instead of files.
struct ArgumentWords {
  std::vector<std::string> known{};
  std::string command{};  ///< prints further words, one a line; empty: there are none
  bool repeated = false;  ///< they stand for every argument, not for the first alone

  bool empty() const { return known.empty() && command.empty(); }
};

/// By the words of the verb: "param get".
using WordsByCommand = std::map<std::string, ArgumentWords>;

/// A program or a verb, with all that belongs to it.
struct Command {
  std::vector<std::string> path;  ///< empty for the program itself, {"param", "get"} for a verb
  std::string description;
  std::string footer;
  std::vector<Argument> arguments;
  std::vector<Command> commands;
  ArgumentWords offers{};  ///< shell completion of its arguments

  std::string words() const;  ///< the path with spaces
};

/// The commands and options of a command line, except those hidden from its help.
/// @param offers  words for shell completion, by verb
Command describe(const CLI::App& app, const WordsByCommand& offers = {});

/// Calls visit(command) for the command and all below it, outer ones first.
template <class Visit>
void for_each_command(const Command& command, const Visit& visit) {
  visit(command);
  for (const Command& below : command.commands) for_each_command(below, visit);
}

}  // namespace cas::base::cli

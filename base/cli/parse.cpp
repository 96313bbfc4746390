// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/parse.hpp"

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "base/cli/verb.hpp"
#include "base/suggestion.hpp"

namespace cas::base::cli {
namespace {

/// The command that was given last: the program itself, or the verb of a verb.
const CLI::App* innermost(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  return given.empty() ? &app : innermost(*given.back());
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* below : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!below->get_name().empty() && !below->get_group().empty()) {
      names.push_back(below->get_name());
    }
  }
  return names;
}

/// Options of the command and of the commands around it, without hidden ones.
std::vector<std::string> option_names(const CLI::App* app) {
  std::vector<std::string> names;
  for (; app != nullptr; app = app->get_parent()) {
    for (const CLI::Option* option : app->get_options()) {
      if (option->get_group().empty()) continue;
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  return names;
}

/// The error text for an unknown word, which replaces CLI11's; empty for any other error.
std::string complaint(const CLI::App& app, const CLI::ParseError& error) {
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  const bool may_be_unknown =
      code == CLI::ExitCodes::ExtrasError || code == CLI::ExitCodes::RequiredError;
  const std::vector<std::string> unknown = app.remaining(true);
  if (!may_be_unknown || unknown.empty()) return {};
  const std::string word = unknown.front().substr(0, unknown.front().find('='));
  const CLI::App* last = innermost(app);
  if (word.starts_with("-")) {
    return "there is no option '" + word + "'" + did_you_mean(word, option_names(last));
  }
  const std::vector<std::string> commands = command_names(*last);
  if (commands.empty()) return {};
  return "there is no command '" + word + "'" + did_you_mean(word, commands);
}

}  // namespace

std::optional<int> parse(CLI::App& app, int argc, char** argv, int usage_code) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    const std::string misspelt = complaint(app, error);
    if (misspelt.empty()) return app.exit(error) == 0 ? 0 : usage_code;
    std::cerr << misspelt << "\nRun with --help for more information.\n";
    return usage_code;
  }
}

const Verb* find_asked(const std::vector<Verb>& verbs) {
  const auto found =
      std::ranges::find_if(verbs, [](const Verb& verb) { return verb.asked->parsed(); });
  return found == verbs.end() ? nullptr : &*found;
}

}  // namespace cas::base::cli

// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/command_tree.hpp"

#include <utility>

#include "base/text.hpp"

namespace cas::base::cli {

namespace {

Argument describe(const CLI::Option& option) {
  Argument argument;
  argument.description = option.get_description();
  argument.required = option.get_required();
  argument.environment = option.get_envname();
  argument.fallback = option.get_default_str();
  argument.positional = option.get_positional();
  if (argument.positional) {
    argument.names = {option.get_name(true)};
    return argument;
  }
  for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  if (option.get_items_expected_max() == 0) return argument;
  const std::string type = option.get_type_name();  // "INT:INT in [1 - 255]"
  argument.value = type.substr(0, type.find(':'));
  return argument;
}

Command describe(const CLI::App& app, std::vector<std::string> path, const WordsByCommand& offers) {
  Command command{.path = std::move(path),
                  .description = app.get_description(),
                  .footer = app.get_footer(),
                  .arguments = {},
                  .commands = {},
                  .offers = {}};
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) command.arguments.push_back(describe(*option));
  }
  const auto is_shown = [](const CLI::App* below) {
    return !below->get_name().empty() && !below->get_group().empty();
  };
  for (const CLI::App* below : app.get_subcommands(is_shown)) {
    std::vector<std::string> words = command.path;
    words.push_back(below->get_name());
    command.commands.push_back(describe(*below, std::move(words), offers));
  }
  if (const auto own = offers.find(command.words()); own != offers.end()) {
    command.offers = own->second;
  }
  return command;
}

}  // namespace

std::string Command::words() const { return joined(path, " "); }

Command describe(const CLI::App& app, const WordsByCommand& offers) {
  return describe(app, {}, offers);
}

}  // namespace cas::base::cli

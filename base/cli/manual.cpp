// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/manual.hpp"

#include <iostream>

#include "base/cli/command_tree.hpp"
#include "base/cli/completion.hpp"
#include "base/cli/man_page.hpp"

namespace cas::base::cli {

void add_manual(CLI::App& app, const std::string& program, const std::string& version) {
  const auto print = [&app, program, version](const std::string& form) {
    const Command command = describe(app);
    if (form == "man") std::cout << man_page(program, version, command);
    if (form == "bash") std::cout << bash_completion(program, command);
    if (form == "zsh") std::cout << zsh_completion(program, command);
    if (form == "fish") std::cout << fish_completion(program, command);
    throw CLI::Success();
  };
  app.add_option_function<std::string>("--manual", print, "Print the manual in this form")
      ->check(CLI::IsMember({"man", "bash", "zsh", "fish"}))
      ->group("");  // not in the help: for the build
}

}  // namespace cas::base::cli

// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/manual.hpp"

#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>

#include "base/cli/completion.hpp"
#include "base/cli/man_page.hpp"

namespace cas::base::cli {
namespace {

/// Today, or the date in SOURCE_DATE_EPOCH (builds of the same text make the same pages).
std::string page_date() {
  std::time_t now = std::time(nullptr);
  if (const char* fixed = std::getenv("SOURCE_DATE_EPOCH")) now = std::strtoll(fixed, nullptr, 10);
  std::tm day{};
  ::gmtime_r(&now, &day);
  char text[16];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d", &day)};
}

}  // namespace

void add_manual(CLI::App& app, const std::string& program, const std::string& version,
                const WordsByCommand& offers) {
  const auto print = [&app, program, version, offers](const std::string& form) {
    const Command command = describe(app, offers);
    if (form == "man") std::cout << man_page(program, version, page_date(), command);
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

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/command_line.hpp"

#include <algorithm>
#include <utility>

#include "base/suggestion.hpp"

namespace cas::casctl {

CLI::Validator in_range(double low, double high) {
  const CLI::Range range(low, high);
  return {[range](std::string& word) {
            double number = 0;
            return CLI::detail::lexical_cast(word, number) ? range(word)
                                                           : "'" + word + "' is not a number";
          },
          range.get_description()};
}

CLI::Validator one_of(std::vector<std::string> known) {
  return {[known = std::move(known)](const std::string& word) {
            if (std::ranges::count(known, word) > 0) return std::string();  // no error
            std::string offer = base::did_you_mean(word, known);
            if (offer.empty()) {
              offer = "; there is";
              for (const std::string& each : known) offer += " " + each;
            }
            return "there is no '" + word + "'" + offer;
          },
          ""};
}

CLI::App* CommandLine::add_verb(CLI::App* group, const std::string& name, const std::string& help,
                                const std::string& example, std::function<int(Session&)> body) {
  CLI::App* verb = group->add_subcommand(name, help);
  verb->fallthrough();
  verb->footer("Example: " + example);
  verb->callback([this, body = std::move(body)] {
    run_ = [this, body] {
      Session session(options_);
      return body(session);
    };
  });
  return verb;
}

CLI::App* CommandLine::add_verb(const std::string& name, const std::string& help,
                                const std::string& example, std::function<int(Session&)> body) {
  return add_verb(&app_, name, help, example, std::move(body));
}

CLI::App* CommandLine::add_group(const std::string& name, const std::string& help) {
  CLI::App* group = app_.add_subcommand(name, help);
  group->fallthrough();
  group->require_subcommand(1);
  return group;
}

}  // namespace cas::casctl

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/command_line.hpp"

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

namespace cas::casctl {

Argument Argument::required() const { return Argument(option_->required()); }

Argument Argument::expected(int least, int most) const {
  return Argument(option_->expected(least, most));
}

Argument Argument::in_range(double low, double high) const {
  const auto is_number = [](const std::string& word) {
    double number = 0;
    return CLI::detail::lexical_cast(word, number) ? std::string()
                                                   : "'" + word + "' is not a number";
  };
  return Argument(option_->check(is_number)->check(CLI::Range(low, high)));
}

Argument Argument::not_negative() const { return Argument(option_->check(CLI::NonNegativeNumber)); }

Argument Argument::with_default() const { return Argument(option_->capture_default_str()); }

Argument Argument::excludes(Argument other) const {
  return Argument(option_->excludes(other.option_));
}

void Verb::add_flag(const std::string& name, bool& value, const std::string& help) const {
  app_->add_flag(name, value, help);
}

Argument Verb::add_option(const std::string& name, std::string& value,
                          const std::string& help) const {
  return Argument(app_->add_option(name, value, help));
}

Argument Verb::add_option(const std::string& name, int& value, const std::string& help) const {
  return Argument(app_->add_option(name, value, help));
}

Argument Verb::add_option(const std::string& name, double& value, const std::string& help) const {
  return Argument(app_->add_option(name, value, help));
}

Argument Verb::add_option(const std::string& name, std::optional<double>& value,
                          const std::string& help) const {
  return Argument(app_->add_option(name, value, help));
}

Argument Verb::add_option(const std::string& name, std::vector<double>& value,
                          const std::string& help) const {
  return Argument(app_->add_option(name, value, help));
}

void Verb::add_check(std::function<std::string()> fault) const {
  app_->parse_complete_callback([name = app_->get_name(), fault = std::move(fault)] {
    if (const std::string sentence = fault(); !sentence.empty()) {
      throw CLI::ValidationError(name, sentence);
    }
  });
}

CommandLine::CommandLine() : app_(std::make_unique<CLI::App>()) {}

CommandLine::~CommandLine() = default;

Verb CommandLine::add_verb(Verb group, const std::string& name, const std::string& help,
                           const std::string& example, std::function<int(Session&)> body) {
  CLI::App* verb = group.app_->add_subcommand(name, help);
  verb->fallthrough();
  verb->footer("Example: " + example);
  verb->callback([this, body = std::move(body)] {
    run_ = [this, body] {
      Session session(options_);
      return body(session);
    };
  });
  return Verb(verb);
}

Verb CommandLine::add_verb(const std::string& name, const std::string& help,
                           const std::string& example, std::function<int(Session&)> body) {
  return add_verb(Verb(app_.get()), name, help, example, std::move(body));
}

Verb CommandLine::add_group(const std::string& name, const std::string& help) {
  CLI::App* group = app_->add_subcommand(name, help);
  group->fallthrough();
  group->require_subcommand(1);
  return Verb(group);
}

}  // namespace cas::casctl

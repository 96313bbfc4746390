// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "casd/casctl/session/session.hpp"

namespace cas::casctl {

/// Check of an option: a number from `low` to `high`. --help shows the limits.
CLI::Validator in_range(double low, double high);
/// Check of an option: one of these words. Another one is answered with what it may have meant.
CLI::Validator one_of(std::vector<std::string> known);

/// The command line under construction: verbs register themselves, parsing picks one. Values of
/// their options are references to objects that outlive the parsing.
class CommandLine {
 public:
  /// Adds a verb with one example line. `body` gets an open session and returns the exit code.
  CLI::App* add_verb(CLI::App* group, const std::string& name, const std::string& help,
                     const std::string& example, std::function<int(Session&)> body);
  CLI::App* add_verb(const std::string& name, const std::string& help, const std::string& example,
                     std::function<int(Session&)> body);
  /// Adds a word that needs one of its verbs behind it.
  CLI::App* add_group(const std::string& name, const std::string& help);

  /// The parser of the command line.
  CLI::App& app() { return app_; }
  Options& options() { return options_; }
  const Options& options() const { return options_; }
  /// Runs the verb that was given. @return the exit code
  int run() const { return run_(); }

 private:
  CLI::App app_;
  Options options_;
  std::function<int()> run_;
};

}  // namespace cas::casctl

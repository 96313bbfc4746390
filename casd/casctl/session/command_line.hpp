// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "casd/casctl/session/session.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace cas::casctl {

/// An option or argument of a verb. Its limits and defaults appear in --help.
class Argument {
 public:
  explicit Argument(CLI::Option* option) : option_(option) {}

  Argument required() const;
  /// How many values it takes.
  Argument expected(int least, int most) const;
  Argument in_range(double low, double high) const;
  Argument not_negative() const;
  /// --help shows the value it has now.
  Argument with_default() const;
  Argument excludes(Argument other) const;

 private:
  CLI::Option* option_;
};

/// A verb of the command line, or a group of verbs. Its values are references to objects that
/// outlive the parsing.
class Verb {
 public:
  explicit Verb(CLI::App* app) : app_(app) {}

  void add_flag(const std::string& name, bool& value, const std::string& help) const;
  Argument add_option(const std::string& name, std::string& value, const std::string& help) const;
  Argument add_option(const std::string& name, int& value, const std::string& help) const;
  Argument add_option(const std::string& name, double& value, const std::string& help) const;
  Argument add_option(const std::string& name, std::optional<double>& value,
                      const std::string& help) const;
  Argument add_option(const std::string& name, std::vector<double>& value,
                      const std::string& help) const;
  /// Checks the values together. @param fault  returns an error text; empty: they are valid
  void add_check(std::function<std::string()> fault) const;

 private:
  friend class CommandLine;
  CLI::App* app_;
};

/// The command line under construction: verbs register themselves, parsing picks one.
class CommandLine {
 public:
  CommandLine();
  ~CommandLine();

  /// Adds a verb with one example line. `body` gets an open session and returns the exit code.
  Verb add_verb(Verb group, const std::string& name, const std::string& help,
                const std::string& example, std::function<int(Session&)> body);
  Verb add_verb(const std::string& name, const std::string& help, const std::string& example,
                std::function<int(Session&)> body);
  /// Adds a word that needs one of its verbs behind it.
  Verb add_group(const std::string& name, const std::string& help);

  /// The parser of the command line.
  CLI::App& app() { return *app_; }
  Options& options() { return options_; }
  const Options& options() const { return options_; }
  /// Runs the verb that was given. @return the exit code
  int run() const { return run_(); }

 private:
  std::unique_ptr<CLI::App> app_;
  Options options_;
  std::function<int()> run_;
};

}  // namespace cas::casctl

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "casd/casctl/session/session.hpp"

namespace cas::casctl {

/// The command line under construction: verbs register themselves, parsing picks one.
struct CommandLine {
  CLI::App app;
  Options options;
  /// Set by the verb that was given. @return the exit code
  std::function<int()> run;

  /// Adds a verb with one example line. `body` gets an open session.
  CLI::App* add_verb(CLI::App& parent, const std::string& name, const std::string& help,
                     const std::string& example, std::function<int(Session&)> body);
  CLI::App* add_verb(const std::string& name, const std::string& help, const std::string& example,
                     std::function<int(Session&)> body) {
    return add_verb(app, name, help, example, std::move(body));
  }
};

void add_status_verbs(CommandLine& line);
void add_flight_verbs(CommandLine& line);
void add_param_verbs(CommandLine& line);
void add_service_verbs(CommandLine& line);
void add_monitor_verb(CommandLine& line);
void add_doctor_verb(CommandLine& line);

}  // namespace cas::casctl

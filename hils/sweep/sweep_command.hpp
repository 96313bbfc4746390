// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace CLI {
class App;
}

namespace cas::hils {

/// The verb `sweep` of hils, with its own verbs.
class SweepCommand {
 public:
  /// Adds it to the program's command line.
  explicit SweepCommand(CLI::App& app);
  ~SweepCommand();
  SweepCommand(const SweepCommand&) = delete;
  SweepCommand& operator=(const SweepCommand&) = delete;

  /// Whether the command line asks for it.
  bool parsed() const;
  /// Does what the command line says. @return exit code
  /// @throws RunStopped, base::ConfigError, std::runtime_error
  int run() const;

 private:
  struct Flags;
  std::unique_ptr<Flags> flags_;
};

}  // namespace cas::hils

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace CLI {
class App;
}

namespace cas::hils {

/// The verbs `tune` and `eval` of hils.
class TuneCommand {
 public:
  /// Adds them to the program's command line.
  explicit TuneCommand(CLI::App& app);
  ~TuneCommand();
  TuneCommand(const TuneCommand&) = delete;
  TuneCommand& operator=(const TuneCommand&) = delete;

  /// Whether the command line asks for one of them.
  bool parsed() const;
  /// Does what the command line says. @return exit code
  /// @throws RunStopped, base::ConfigError, std::runtime_error
  int run() const;

 private:
  struct Flags;
  std::unique_ptr<Flags> flags_;
};

}  // namespace cas::hils

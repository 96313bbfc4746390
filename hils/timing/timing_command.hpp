// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace CLI {
class App;
}

namespace cas::hils {

/// `hils timing`: measures the line to a controller before any flight.
class TimingCommand {
 public:
  /// Adds it to the program's command line.
  explicit TimingCommand(CLI::App& app);
  ~TimingCommand();
  TimingCommand(const TimingCommand&) = delete;
  TimingCommand& operator=(const TimingCommand&) = delete;

  bool parsed() const;
  /// Measures and reports. @return exit code @throws BoardError, base::ConfigError
  int run() const;

 private:
  struct Flags;
  std::unique_ptr<Flags> flags_;
};

}  // namespace cas::hils

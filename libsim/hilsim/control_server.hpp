// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "libsim/core/run/sim_loop.hpp"

namespace cas::sim {

/// The control socket and the signals of hilsim, on a thread of its own.
///
///   SIGINT, SIGTERM, sim.quit   end in good order        SIGUSR1   pause, or resume
///   SIGUSR2                     one step while paused    SIGHUP    reset
///
/// Methods sim.status, pause, resume, step {n}, run_until {time_s}, reset, stats, phase {name},
/// quit; each is carried out between two steps and answered when it is done. For a picture:
/// sim.scene, mesh {hash}, watch, which is sampled 60 times a second at most, however many ask.
class ControlServer {
 public:
  /// Blocks the signals for the calling thread and those it starts. Before SimRunner::start().
  /// @throws base::ConfigError
  ControlServer(SimLoop& loop, const std::optional<std::filesystem::path>& unix_path);
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::sim

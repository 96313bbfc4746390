// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "fcu/core/fcu_config.hpp"

namespace cas::fcu {

struct EmulatorOptions {
  std::filesystem::path link;
  std::optional<std::filesystem::path> stats;    ///< JSON, written at the end
  std::optional<std::filesystem::path> ledger;   ///< CSV, written at the end
  std::optional<std::filesystem::path> control;  ///< Unix socket for JSON-RPC
  std::optional<std::filesystem::path> params;   ///< parameter file
  std::optional<std::filesystem::path> files;    ///< folder to serve over MAVLink FTP
};

/// The flight controller behind its serial line on a pseudo-terminal, in real time: one thread,
/// one event loop.
///
///   PTY --> line up --> FlightController --> line down --> PTY
///    ^ read while the line has room            write, whole packets only
class Emulator {
 public:
  /// @throws base::ConfigError
  Emulator(const FcuConfig& config, EmulatorOptions options);
  ~Emulator();

  /// "pty /dev/pts/N link PATH"
  std::string endpoints() const;
  /// Runs until a signal (SIGINT, SIGTERM); then writes the files of the options.
  void run();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::fcu

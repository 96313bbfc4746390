// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "casd/topology/topology.hpp"

namespace cas::casd {

struct AppOptions {
  std::filesystem::path topology_file;  ///< or its folder; empty: endpoints, no reload
  std::filesystem::path ledger_file;    ///< each HIL packet at each link, at the end; empty: none
  std::filesystem::path stats_file;     ///< written at the end; empty: none
  std::string name;                     ///< of this casd, for people; empty: its topology's file
  bool lockstep = false;                ///< overrides `pace` of the topology, after a reload too
};

/// The running program: links, commander and command port around one io thread. Ends on SIGTERM or
/// SIGINT; SIGHUP and the method casd.reload read the topology again.
class App {
 public:
  /// @throws base::ConfigError
  App(AppOptions options, Topology topology);
  ~App();

  /// Opens the command port. @throws base::ConfigError
  void listen();
  /// Runs until a signal ends it.
  void run();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::casd

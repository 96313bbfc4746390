// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/rpc/server.hpp"
#include "casd/autopilot_log/autopilot_logs.hpp"
#include "casd/tlog/recorder.hpp"

namespace cas::casd {

/// Objects that the daemon's methods act on.
struct DaemonHooks {
  /// Reads the topology again. @return why not; nullopt when it is in force
  std::function<std::optional<std::string>()> reload;
  Recorder& recorder;
  /// Runs work on the server's thread; from any thread.
  std::function<void(std::function<void()> work)> post;
};

/// A recording as log.status and casd.status tell it.
nlohmann::json recording_json(const Recorder& recorder);
/// The logs of autopilots as casd.status tells them.
nlohmann::json autopilot_logs_json(const AutopilotLogsStatus& status);

/// Methods casd.reload, log.start, log.stop, log.status.
void add_daemon_methods(base::rpc::Server& server, DaemonHooks hooks);

}  // namespace cas::casd

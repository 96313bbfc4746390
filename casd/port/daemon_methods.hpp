// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/rpc/server.hpp"
#include "casd/autopilot_log/autopilot_logs.hpp"
#include "casd/tlog/recorder.hpp"

namespace cas::base {
class ConfigNode;
}

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

/// Callbacks of link.add and link.remove. If `add` or `remove` throws base::ConfigError, nothing
/// has changed.
struct LinkHooks {
  /// Adds a link, see with_link().
  /// @param tried  called with its name once it has tried to open, or after two seconds
  std::function<void(const base::ConfigNode& request,
                     std::function<void(const std::string& name)> tried)>
      add;
  /// @param force  also the link of an armed vehicle
  std::function<void(const std::string& name, bool force)> remove;
  /// Called for each call. @param refusal  nullopt: it was done
  std::function<void(const std::string& client, const std::string& method,
                     const nlohmann::json& params, const std::optional<std::string>& refusal)>
      audit;
};

/// Methods link.add and link.remove.
void add_link_methods(base::rpc::Server& server, const LinkHooks& hooks);

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "base/rpc/server.hpp"
#include "casd/tlog/tlog_writer.hpp"

namespace cas::casd {

/// What the methods of the daemon act on.
struct DaemonHooks {
  /// Reads the topology again. @return why not; empty when it is in force
  std::function<std::string()> reload;
  TlogWriter& tlog;
};

/// Methods casd.reload, log.start, log.stop, log.status.
void add_daemon_methods(base::rpc::Server& server, DaemonHooks hooks);

}  // namespace cas::casd

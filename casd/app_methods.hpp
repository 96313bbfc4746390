// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "base/rpc/server.hpp"
#include "casd/link_set.hpp"
#include "casd/port/command_figures.hpp"
#include "casd/port/command_server.hpp"
#include "casd/tlog/tlog_writer.hpp"

namespace cas::casd {

struct AppHooks {
  /// Reads the topology again. @return why not; empty when it is in force
  std::function<std::string()> reload;
  TlogWriter& tlog;
};

/// Methods casd.reload, log.start, log.stop, log.status.
void add_app_methods(base::rpc::Server& server, AppHooks hooks);

/// Where the command port takes its figures from; both outlive it.
FiguresSource make_figures_source(LinkSet& links, const CommandServer& commands);

/// Names and values of the generated dialect and of the topology's own. @throws base::ConfigError
std::shared_ptr<const MessageDecoder> load_decoder(const Topology& topology);

/// Writes the figures of the run as JSON, beside the file and renamed.
void write_stats(const std::filesystem::path& file, const CommandFigures& figures);

}  // namespace cas::casd

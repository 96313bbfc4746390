// SPDX-License-Identifier: BSD-3-Clause
#include "casd/app_methods.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/log.hpp"

namespace cas::casd {
namespace {

using base::rpc::Reply;
using nlohmann::json;

json log_status(const TlogWriter& tlog) {
  return json{{"active", tlog.active()},
              {"file", tlog.file().string()},
              {"recorded", tlog.recorded()},
              {"left_out", tlog.left_out()}};
}

void start_log(TlogWriter& tlog, const json& params, const Reply& reply) {
  if (!params.is_object() || !params.contains("file") || !params["file"].is_string()) {
    return reply.error(base::rpc::kInvalidParams, "log.start takes {\"file\": PATH}", nullptr);
  }
  try {
    tlog.start(params["file"].get<std::string>());
    reply.result(log_status(tlog));
  } catch (const base::ConfigError& error) {
    reply.error(base::rpc::kRefused, error.what(), nullptr);
  }
}

}  // namespace

void add_app_methods(base::rpc::Server& server, AppHooks hooks) {
  server.add_method("casd.reload", [reload = hooks.reload](const json&, const Reply& reply) {
    const std::string trouble = reload();
    if (!trouble.empty()) return reply.error(base::rpc::kRefused, trouble, nullptr);
    reply.result(json{{"reloaded", true}});
  });
  TlogWriter& tlog = hooks.tlog;
  server.add_method("log.start", [&tlog](const json& params, const Reply& reply) {
    start_log(tlog, params, reply);
  });
  server.add_method("log.stop", [&tlog](const json&, const Reply& reply) {
    tlog.stop();
    reply.result(log_status(tlog));
  });
  server.add_method("log.status",
                    [&tlog](const json&, const Reply& reply) { reply.result(log_status(tlog)); });
}

FiguresSource make_figures_source(LinkSet& links, const CommandServer& commands) {
  return {.monitor = &links.monitor(),
          .topology = [&links]() -> const Topology& { return links.topology(); },
          .now = base::steady_now,
          .started = base::steady_now(),
          .vehicles = [&commands] { return commands.vehicles(); },
          .taps = &links.taps()};
}

void write_stats(const std::filesystem::path& file, const CommandFigures& figures) {
  std::filesystem::path beside = file;
  beside += ".new";
  std::ofstream out(beside);
  out << figures.status().dump(2) << "\n";
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, file, error);
  if (!out || error) base::log::error("cannot write " + file.string());
}

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/command_port.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/install_paths.hpp"
#include "base/log.hpp"
#include "base/rpc/server.hpp"
#include "casd/command_figures.hpp"
#include "casd/command_params.hpp"
#include "casd/command_server.hpp"
#include "casd/vehicle_commander.hpp"

namespace cas::casd {
namespace {

using nlohmann::json;

CommanderOptions commander_options(const Topology& topology) {
  CommanderOptions options;
  options.self = topology.self;
  options.heartbeat_hz = topology.commanding.heartbeat_hz;
  options.allow_not_hil = topology.commanding.allow_not_hil;
  return options;
}

/// Without `gains` in the topology the shipped map serves, where there is one.
GainMap load_gains(const Topology& topology) {
  if (!topology.gains.empty()) return GainMap::load(topology.gains);
  for (const std::filesystem::path& folder : base::config_dirs()) {
    if (std::filesystem::exists(folder / "gains.yaml")) return GainMap::load(folder / "gains.yaml");
  }
  return {};
}

/// A log goes into a new .tlog file: a client of the port must not overwrite what it likes.
std::filesystem::path log_file(const std::string& text) {
  const std::filesystem::path file(text);
  if (file.extension() != ".tlog") throw BadParams("\"file\" must end in .tlog");
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) throw BadParams(text + " exists already");
  return file;
}

}  // namespace

struct CommandPort::Impl {
  explicit Impl(CommandPortNeeds given)
      : needs(std::move(given)),
        server(*needs.io),
        commander(commander_options(needs.topology()), needs.send),
        command_server(server, commander, load_gains(needs.topology()), hooks()),
        figures(server, figures_source()) {
    add_service_methods();
  }

  CommandServerHooks hooks() {
    CommandServerHooks hooks;
    hooks.now = needs.now;
    hooks.link_name = [this](LinkId id) {
      for (const LinkStatus& link : needs.monitor->links()) {
        if (link.id == id) return link.name;
      }
      return std::string("?");
    };
    hooks.audit = [](const std::string& line) { base::log::info("audit: " + line); };
    return hooks;
  }

  FiguresSource figures_source() {
    return {.monitor = needs.monitor,
            .topology = needs.topology,
            .now = needs.now,
            .started = needs.now(),
            .vehicles = [this] { return command_server.vehicles(); }};
  }

  void add_service_methods() {
    if (needs.start_log) {
      add_service("log.start", [this](CommandParams& params) {
        const std::filesystem::path file = log_file(params.text("file"));
        params.finish();
        needs.start_log(file);
        return json{{"file", file.string()}};
      });
    }
    if (needs.stop_log) {
      add_service("log.stop", [this](CommandParams& params) {
        params.finish();
        needs.stop_log();
        return json{{"stopped", true}};
      });
    }
    if (needs.reload) {
      add_service("casd.reload", [this](CommandParams& params) {
        params.finish();
        needs.reload();
        return json{{"reloaded", true}};
      });
    }
  }

  /// A method of the daemon itself: audited; what it cannot do is a refusal in words.
  void add_service(const std::string& name, std::function<json(CommandParams&)> body) {
    server.add_method(name, [name, body](const json& params, const base::rpc::Reply& reply) {
      std::string what = "done";
      try {
        CommandParams reader(params);
        reply.result(body(reader));
      } catch (const BadParams& error) {
        what = error.what();
        reply.error(base::rpc::kInvalidParams, what, nullptr);
      } catch (const base::ConfigError& error) {
        what = error.what();
        reply.error(base::rpc::kRefused, what, nullptr);
      }
      base::log::info("audit: " + name + ": " + what);
    });
  }

  CommandPortNeeds needs;
  base::rpc::Server server;
  VehicleCommander commander;
  CommandServer command_server;
  CommandFigures figures;
};

CommandPort::CommandPort(CommandPortNeeds needs)
    : impl_(std::make_unique<Impl>(std::move(needs))) {}

CommandPort::~CommandPort() = default;

Station& CommandPort::station() { return impl_->commander; }

const VehicleCommander& CommandPort::commander() const { return impl_->commander; }

std::uint16_t CommandPort::listen() {
  const CommandPortConfig& config = impl_->needs.topology().command_port;
  if (!config.token_file.empty()) impl_->server.require_token(config.token_file);
  if (!config.unix_path.empty()) impl_->server.listen_unix(config.unix_path);
  return impl_->server.listen_tcp(config.address, config.port);
}

void CommandPort::publish() { impl_->figures.publish(); }

std::string CommandPort::stats() const {
  return impl_->figures.status().dump(2, ' ', false, json::error_handler_t::replace);
}

void CommandPort::close() { impl_->server.close(); }

}  // namespace cas::casd

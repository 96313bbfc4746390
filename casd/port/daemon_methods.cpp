// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/daemon_methods.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "casd/port/call_json.hpp"
#include "casd/tlog/tlog_name.hpp"

namespace cas::casd {
namespace {

using base::rpc::Reply;
using nlohmann::json;

/// A recording goes into a new file in the one folder for recordings: a client of the port must not
/// make files where it likes.
void start_log(Recorder& recorder, CallParams& params, TlogWriter::Done done) {
  const std::string name = params.optional_text("file").value_or("");
  const auto at_least = [&params](const std::string& key, double least) {
    const double number = params.optional_number(key).value_or(0);
    if (number != 0 && (number < least || number > 1e6)) {
      throw BadParams(fmt::format("\"{}\" must be 0 (off) or from {:f} to 1e6", key, least));
    }
    return number;
  };
  TlogRotation rotation;
  rotation.max_bytes = static_cast<std::uint64_t>(at_least("rotate_mib", 0.001) * 1024 * 1024);
  rotation.max_age = base::from_seconds(at_least("rotate_minutes", 0.001) * 60);
  rotation.keep = static_cast<int>(params.optional_integer("keep", 0, 1'000'000).value_or(0));
  params.finish();
  if (const auto fault = tlog_name_fault(name); fault && !name.empty()) {
    throw BadParams("\"file\" " + *fault + ": it is a name in " +
                    recorder.config().folder.string() + ", the folder for recordings");
  }
  recorder.start(name, rotation, std::move(done));
}

void audit(const std::string& client, const std::string& name, const json& /*params*/,
           const std::optional<std::string>& refusal) {
  base::log::info("audit: " + client + " " + name + ": " + refusal.value_or("done"));
}

/// A method that begins or ends a recording: answered with its state once the disk has answered.
void add_log_method(base::rpc::Server& server, const std::string& name, const DaemonHooks& hooks,
                    std::function<void(CallParams&, TlogWriter::Done)> body) {
  const auto audit_refusal = [](const auto& client, const auto& method, const auto& params,
                                const auto& refusal) {
    if (refusal) audit(client, method, params, refusal);
  };
  add_change(server, name, audit_refusal,
             [name, hooks, body](CallParams& reader, const Reply& reply) {
               std::string ended;
               if (hooks.recorder.records()) {
                 ended = hooks.recorder.status(base::steady_now()).file.string();
               }
               body(reader, [name, hooks, reply, ended](const std::optional<std::string>& fault,
                                                        const TlogStatus&) {
                 hooks.post([name, hooks, reply, ended, fault] {
                   if (fault) {
                     reply.error(base::rpc::kRefused, *fault, nullptr);
                   } else {
                     json status = recording_json(hooks.recorder);
                     if (!ended.empty()) status["ended"] = ended;
                     reply.result(status);
                   }
                   audit(reply.client, name, {}, fault);
                 });
               });
             });
}

}  // namespace

json recording_json(const Recorder& recorder) {
  const TlogStatus status = recorder.status(base::steady_now());
  json recording{{"active", status.active},
                 {"awaits_arming", recorder.awaits_arming()},
                 {"folder", recorder.config().folder.string()},
                 {"file", status.file.string()},
                 {"recorded", status.recorded},
                 {"left_out", status.left_out},
                 {"bytes", status.bytes}};
  if (status.paused) {
    recording["paused"] = *status.paused;
    recording["paused_s"] = base::to_seconds(status.paused_for);
  }
  return recording;
}

json autopilot_logs_json(const AutopilotLogsStatus& status) {
  json logs{{"folder", status.files.folder.string()}, {"vehicles", json::array()}};
  if (status.files.paused) {
    logs["paused"] = *status.files.paused;
    logs["paused_s"] = base::to_seconds(status.files.paused_for);
  }
  for (const AutopilotLogStatus& log : status.vehicles) {
    json one{{"vehicle", log.system}, {"wanted", log.wanted}};
    if (log.file) one.update({{"file", log.file->path.string()}, {"bytes", log.file->bytes}});
    if (!log.trouble.empty()) one["trouble"] = log.trouble;
    logs["vehicles"].push_back(std::move(one));
  }
  return logs;
}

void add_daemon_methods(base::rpc::Server& server, DaemonHooks hooks) {
  add_change(server, "casd.reload", audit,
             [reload = hooks.reload](CallParams& params, const Reply& reply) {
               params.finish();
               if (const auto trouble = reload()) throw base::ConfigError(*trouble);
               reply.result(json{{"reloaded", true}});
             });
  Recorder& recorder = hooks.recorder;
  add_log_method(server, "log.start", hooks,
                 [&recorder](CallParams& params, TlogWriter::Done done) {
                   start_log(recorder, params, std::move(done));
                 });
  add_log_method(server, "log.stop", hooks, [&recorder](CallParams& params, TlogWriter::Done done) {
    params.finish();
    recorder.stop(std::move(done));
  });
  add_look(server, "log.status", [&recorder](CallParams& params) {
    params.finish();
    return recording_json(recorder);
  });
}

namespace {

using base::rpc::Reply;
using nlohmann::json;

/// The parameters as a node of a topology: JSON is YAML.
base::ConfigNode request_of(CallParams& params) {
  json request{{"entry", params.value("entry")}};
  if (!request["entry"].is_object()) {
    throw BadParams("\"entry\" must be an object: a link, as a topology has it");
  }
  if (json routes = params.value("routes"); !routes.is_null()) {
    if (!routes.is_array()) throw BadParams("\"routes\" must be a list, as a topology has it");
    request["routes"] = std::move(routes);
  }
  params.finish();
  return base::ConfigNode::parse(request.dump(-1, ' ', false, json::error_handler_t::replace),
                                 "link.add");
}

}  // namespace

void add_link_methods(base::rpc::Server& server, const LinkHooks& hooks) {
  add_change(server, "link.add", hooks.audit,
             [add = hooks.add](CallParams& params, const Reply& reply) {
               add(request_of(params), [reply](const std::string& name) {
                 reply.result(json{{"link", name}});
               });
             });
  add_change(server, "link.remove", hooks.audit,
             [remove = hooks.remove](CallParams& params, const Reply& reply) {
               const std::string name = params.text("link");
               const bool force = params.flag("force");
               params.finish();
               remove(name, force);
               reply.result(json{{"link", name}});
             });
}

}  // namespace cas::casd

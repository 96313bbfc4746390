// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/daemon_methods.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "casd/port/call_json.hpp"
#include "casd/tlog/tlog_name.hpp"

namespace cas::casd {
namespace {

using base::rpc::Reply;
using nlohmann::json;

json log_status(const Recorder& recorder) {
  json status = recording_json(recorder.status(base::steady_now()));
  status["folder"] = recorder.config().folder.string();
  status["awaits_arming"] = recorder.awaits_arming();
  return status;
}

/// A recording goes into a new file in the one folder for recordings: a client of the port must not
/// make files where it likes.
void start_log(Recorder& recorder, CallParams& params, TlogWriter::Done done) {
  const std::string name = params.optional_text("file").value_or("");
  const auto at_least = [&params](const std::string& key, double least) {
    const double number = params.optional_number(key).value_or(0);
    if (number != 0 && (number < least || number > 1e6)) {
      throw BadParams("\"" + key + "\" must be 0 (off) or from " + std::to_string(least) +
                      " to 1e6");
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

void audit(const Reply& reply, const std::string& name, const std::string& what) {
  base::log::info("audit: " + reply.client + " " + name + ": " + what);
}

/// A method of the daemon itself. Changes are audited; failures are returned as error messages.
void add_method(base::rpc::Server& server, const std::string& name, bool audited,
                std::function<json(CallParams&)> body) {
  server.add_method(
      name,
      [name, audited, body](const json& params, const Reply& reply) {
        const auto fault =
            answer_call(params, reply, [&](CallParams& reader) { reply.result(body(reader)); });
        if (audited) audit(reply, name, fault.value_or("done"));
      },
      audited ? kWeightOfChange : 1);
}

/// A method that begins or ends a recording: answered with its state once the disk has answered.
void add_log_method(base::rpc::Server& server, const std::string& name, const DaemonHooks& hooks,
                    std::function<void(CallParams&, TlogWriter::Done)> body) {
  server.add_method(
      name,
      [name, hooks, body](const json& params, const Reply& reply) {
        const TlogWriter::Done done = [name, hooks, reply](const std::optional<std::string>& fault,
                                                           const TlogStatus&) {
          hooks.post([name, hooks, reply, fault] {
            if (fault) {
              reply.error(base::rpc::kRefused, *fault, nullptr);
            } else {
              reply.result(log_status(hooks.recorder));
            }
            audit(reply, name, fault.value_or("done"));
          });
        };
        const auto fault =
            answer_call(params, reply, [&](CallParams& reader) { body(reader, done); });
        if (fault) audit(reply, name, *fault);
      },
      kWeightOfChange);
}

}  // namespace

json recording_json(const TlogStatus& status) {
  json recording{{"active", status.active},
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

void add_daemon_methods(base::rpc::Server& server, DaemonHooks hooks) {
  add_method(server, "casd.reload", true, [reload = hooks.reload](CallParams& params) {
    params.finish();
    if (const auto trouble = reload()) throw base::ConfigError(*trouble);
    return json{{"reloaded", true}};
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
  add_method(server, "log.status", false, [&recorder](CallParams& params) {
    params.finish();
    return log_status(recorder);
  });
}

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/daemon_methods.hpp"

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "casd/port/call_json.hpp"

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

/// A log goes into a new .tlog file: a client of the port must not overwrite what it likes.
json start_log(TlogWriter& tlog, CallParams& params) {
  const std::filesystem::path file(params.text("file"));
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
  std::error_code ignored;
  if (file.extension() != ".tlog") throw BadParams("\"file\" must end in .tlog");
  if (std::filesystem::exists(file, ignored)) throw BadParams(file.string() + " exists already");
  tlog.start(file, rotation);
  return log_status(tlog);
}

/// A method of the daemon itself. Changes are audited; failures are returned as error messages.
void add_method(base::rpc::Server& server, const std::string& name, bool audited,
                std::function<json(CallParams&)> body) {
  server.add_method(name, [name, audited, body](const json& params, const Reply& reply) {
    std::string what = "done";
    try {
      CallParams reader(params);
      reply.result(body(reader));
    } catch (const BadParams& error) {
      what = error.what();
      reply.error(base::rpc::kInvalidParams, what, nullptr);
    } catch (const base::ConfigError& error) {
      what = error.what();
      reply.error(base::rpc::kRefused, what, nullptr);
    }
    if (audited) base::log::info("audit: " + reply.client + " " + name + ": " + what);
  });
}

}  // namespace

void add_daemon_methods(base::rpc::Server& server, DaemonHooks hooks) {
  add_method(server, "casd.reload", true, [reload = hooks.reload](CallParams& params) {
    params.finish();
    const std::string trouble = reload();
    if (!trouble.empty()) throw base::ConfigError(trouble);
    return json{{"reloaded", true}};
  });
  TlogWriter& tlog = hooks.tlog;
  add_method(server, "log.start", true,
             [&tlog](CallParams& params) { return start_log(tlog, params); });
  add_method(server, "log.stop", true, [&tlog](CallParams& params) {
    params.finish();
    tlog.stop();
    return log_status(tlog);
  });
  add_method(server, "log.status", false, [&tlog](CallParams& params) {
    params.finish();
    return log_status(tlog);
  });
}

}  // namespace cas::casd

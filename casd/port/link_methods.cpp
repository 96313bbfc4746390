// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/link_methods.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/config/config.hpp"
#include "casd/port/call_json.hpp"

namespace cas::casd {
namespace {

using base::rpc::Reply;
using nlohmann::json;

/// Adds a method that is audited whatever becomes of it.
void add_method(base::rpc::Server& server, const std::string& name, const LinkHooks& hooks,
                std::function<json(CallParams&)> body) {
  server.add_method(
      name,
      [name, audit = hooks.audit, body = std::move(body)](const json& params, const Reply& reply) {
        const auto refusal =
            answer_call(params, reply, [&](CallParams& reader) { reply.result(body(reader)); });
        audit(reply.client, name, params, refusal);
      },
      kWeightOfChange);
}

/// JSON is YAML: the parameters are read as a topology is.
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
  add_method(server, "link.add", hooks, [add = hooks.add](CallParams& params) {
    return json{{"link", add(request_of(params))}};
  });
  add_method(server, "link.remove", hooks, [remove = hooks.remove](CallParams& params) {
    const std::string name = params.text("link");
    const bool force = params.flag("force");
    params.finish();
    remove(name, force);
    return json{{"link", name}};
  });
}

}  // namespace cas::casd

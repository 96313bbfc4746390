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

/// Adds a method of which each call is audited, also one that is refused.
void add_method(base::rpc::Server& server, const std::string& name, const LinkHooks& hooks,
                std::function<void(CallParams&, const Reply&)> body) {
  server.add_method(
      name,
      [name, audit = hooks.audit, body = std::move(body)](const json& params, const Reply& reply) {
        const auto refusal =
            answer_call(params, reply, [&](CallParams& reader) { body(reader, reply); });
        audit(reply.client, name, params, refusal);
      },
      kWeightOfChange);
}

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
  add_method(server, "link.add", hooks, [add = hooks.add](CallParams& params, const Reply& reply) {
    add(request_of(params), [reply](const std::string& name) {
      reply.result(json{{"link", name}});
    });
  });
  add_method(server, "link.remove", hooks,
             [remove = hooks.remove](CallParams& params, const Reply& reply) {
               const std::string name = params.text("link");
               const bool force = params.flag("force");
               params.finish();
               remove(name, force);
               reply.result(json{{"link", name}});
             });
}

}  // namespace cas::casd

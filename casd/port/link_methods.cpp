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

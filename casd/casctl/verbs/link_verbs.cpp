// SPDX-License-Identifier: BSD-3-Clause

#include <memory>
#include <optional>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "base/rpc/client.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using base::ConfigNode;
using nlohmann::json;

/// The value as T; nullopt: it is no T.
template <class T>
std::optional<json> value_as(const ConfigNode& node) {
  try {
    return node.as<T>();
  } catch (const base::ConfigError&) {
    return std::nullopt;
  }
}

/// YAML as JSON.
json json_of(const ConfigNode& node) {
  if (node.is_map()) {
    json map = json::object();
    for (const auto& [key, value] : node.entries()) map[key] = json_of(value);
    return map;
  }
  if (node.is_list()) {
    json list = json::array();
    for (const ConfigNode& each : node.items()) list.push_back(json_of(each));
    return list;
  }
  if (node.is_null()) return nullptr;
  if (const auto flag = value_as<bool>(node)) return *flag;
  if (const auto whole = value_as<std::int64_t>(node)) return *whole;
  if (const auto number = value_as<double>(node)) return *number;
  return node.as<std::string>();
}

struct NewLink {
  std::string link;
  std::string name;
  std::string accept;
  std::string routes;
};

/// @throws base::ConfigError if a value is not YAML
json request_of(const NewLink& asked) {
  json entry = json::object();
  if (asked.link.starts_with('{')) {
    entry = json_of(ConfigNode::parse(asked.link, "LINK"));
  } else {
    entry["endpoint"] = asked.link;
  }
  if (!asked.name.empty()) entry["name"] = asked.name;
  if (!asked.accept.empty()) entry["accept"] = json_of(ConfigNode::parse(asked.accept, "--accept"));
  json request{{"entry", std::move(entry)}};
  if (!asked.routes.empty()) {
    request["routes"] = json_of(ConfigNode::parse(asked.routes, "--routes"));
  }
  return request;
}

/// As link.list has it.
json link_named(Session& session, const std::string& name) {
  for (const json& link : session.call("link.list")) {
    if (link.value("name", "") == name) return link;
  }
  return json::object();  // removed again
}

int add_link(Session& session, const NewLink& asked) {
  const std::string name = session.call("link.add", request_of(asked)).at("link");
  const json link = link_named(session, name);
  const std::string state = link.value("state", "?");
  report(session.options(), link,
         "link " + printable(name) + " added, " + state + ": " + printable(endpoint_text(link)) +
             (state == "down" ? "; casd goes on trying" : ""));
  return kDone;
}

}  // namespace

void add_link_verbs(CommandLine& line) {
  CLI::App* const link = line.add_group("link", "Add or remove links of a running casd");
  const auto asked = std::make_shared<NewLink>();
  CLI::App* const add = line.add_verb(
      link, "add", "Open one more link, until it is removed or the topology is read again",
      "casctl link add udp:127.0.0.1:14551",
      [asked](Session& session) { return add_link(session, *asked); });
  add->add_option("LINK", asked->link,
                  "An endpoint (udp:HOST:PORT, tcp:PORT, serial:DEVICE:BAUD), or a link as a "
                  "topology has it, in braces")
      ->required();
  add->add_option("--name", asked->name, "Its name; without it an endpoint gets one");
  add->add_option("--accept", asked->accept,
                  "What it takes in: everything, nothing or a block; without it what ground "
                  "stations say");
  add->add_option("--routes", asked->routes,
                  "Its routes, a list as in a topology; without it to and from every link, but no "
                  "HIL messages");
  struct Removal {
    std::string name;
    bool force = false;
  };
  const auto removal = std::make_shared<Removal>();
  CLI::App* const remove = line.add_verb(
      link, "remove", "Close a link", "casctl link remove udp2", [removal](Session& session) {
        json params{{"link", removal->name}};
        if (removal->force) params["force"] = true;
        const json result = session.call("link.remove", params);
        report(session.options(), result, "link " + printable(removal->name) + " removed");
        return kDone;
      });
  remove->add_option("NAME", removal->name, "Of the link")->required();
  remove->add_flag("--force", removal->force, "Also the only link of an armed vehicle");
}

}  // namespace cas::casctl

// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/link_change.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "base/text.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/topology/endpoint_conflict.hpp"
#include "casd/topology/endpoint_notation.hpp"
#include "casd/topology/message_keys.hpp"

namespace cas::casd {
namespace {

using base::ConfigNode;

/// udp, udp2, udp3: the first that no link has.
std::string free_name(const Topology& topology, LinkType type) {
  std::string word(to_string(type));
  word = word.substr(0, word.find('_'));
  std::string name = word;
  for (int nth = 2; find_link(topology.links, name) != nullptr; ++nth)
    name = fmt::format("{}{}", word, nth);
  return name;
}

/// The entry, with the keys that its `endpoint` stands for; a name or baud of its own wins.
ConfigNode with_endpoint(const Topology& topology, const ConfigNode& entry) {
  const auto endpoint = entry.find("endpoint");
  if (!endpoint) return entry;
  for (const char* key : {"type", "local", "remote", "device"}) {
    if (entry.has(key)) entry.at(key).fail("'endpoint' says that already");
  }
  LinkConfig link;
  try {
    link = parse_endpoint(endpoint->as<std::string>());
  } catch (const base::ConfigError& error) {
    endpoint->fail(error.what());
  }
  link.name = free_name(topology, link.type);
  if (link.type == LinkType::kSerial && link.baud.empty()) {
    if (const unsigned rate = usual_baud(link.device); rate > 0) link.baud = {rate};
  }
  constexpr std::size_t kDash = 2;
  return entry.merged_over(ConfigNode::parse(link_entry(link).substr(kDash), "endpoint"));
}

/// Takes in the traffic of ground stations, a log that of its vehicles; but nothing with the id of
/// a known vehicle or casd.
AcceptRule rule_of_strangers(const Topology& topology, const LinkConfig& link,
                             const std::vector<std::uint8_t>& vehicles) {
  AcceptRule rule = link.accept;
  rule.ground_station = link.type != LinkType::kTlog;
  rule.block_systems = vehicles;
  const std::uint8_t self = topology.self.system;
  if (std::ranges::find(vehicles, self) == vehicles.end()) rule.block_systems.push_back(self);
  return rule;
}

/// Whether a file lies directly in a folder, behind all symlinks.
bool is_in(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code unresolved;
  const auto resolve = [&unresolved](const std::filesystem::path& path) {
    const auto whole =
        std::filesystem::weakly_canonical(std::filesystem::absolute(path), unresolved);
    return whole.has_filename() ? whole : whole.parent_path();
  };
  return resolve(file).parent_path() == resolve(folder) && !unresolved;
}

/// A client of the command port may be a user who may not read what casd may: logs come from the
/// folder of recordings, keys from a folder whose keys the topology names already. Nor may it have
/// a log move a vehicle that the topology's `allow_not_hil` guards.
void refuse_what_files_may(const Topology& topology, const LinkConfig& link,
                           const ConfigNode& entry) {
  const std::filesystem::path folder = topology.log.folder.empty() ? "." : topology.log.folder;
  if (link.type == LinkType::kTlog && !is_in(link.file, folder)) {
    entry.at("file").fail("at run time only logs in the folder of recordings are played: " +
                          std::filesystem::absolute(folder).string());
  }
  if (link.type == LinkType::kTlog && link.to_not_hil == ToNotHil::kAll) {
    entry.at("to_not_hil")
        .fail("'all' of a log is for files: at run time it may only stop vehicles not in HIL");
  }
  if (!link.signing) return;
  const bool known = std::ranges::any_of(topology.links, [&link](const LinkConfig& other) {
    return other.signing && is_in(link.signing->key_file, other.signing->key_file.parent_path());
  });
  if (!known) {
    entry.at("signing").fail(
        "at run time only keys in a folder that has the key of a link of the topology are used");
  }
}

LinkConfig parse_new_link(const Topology& topology, const ConfigNode& entry,
                          const std::vector<std::uint8_t>& vehicles) {
  const auto device = entry.find("device");
  if (device && device->as<std::string>().find("${") != std::string::npos) {
    device->fail("variables are for files: clients must not read casd's environment");
  }
  LinkConfig link = parse_link(entry);
  refuse_what_files_may(topology, link, entry);
  if (find_link(topology.links, link.name) != nullptr) {
    entry.at("name").fail("'" + link.name + "' is the name of another link");
  }
  if (const auto conflict = endpoint_conflict(link, topology.links)) entry.fail(*conflict);
  if (const auto conflict = endpoint_conflict(link, topology.command_port)) entry.fail(*conflict);
  const LinkConfig* const same = link_to_same_peer(link, topology.links);
  if (same != nullptr && (link.group.empty() || link.group != same->group)) {
    entry.fail("link '" + same->name + "' sends to " + link.remote +
               " already: each packet would arrive there twice");
  }
  if (topology.links.size() == kMaxLinks) {
    entry.fail(fmt::format("there are {} links already", kMaxLinks));
  }
  if (!entry.has("accept") && !link.sniffer)
    link.accept = rule_of_strangers(topology, link, vehicles);
  return link;
}

/// To and from every other link, without HIL messages, which would fly a vehicle.
std::vector<RouteConfig> usual_routes(const Topology& topology, const std::string& name) {
  ForwardRule no_hil;
  no_hil.block = hil_messages();
  std::vector<RouteConfig> routes;
  for (RouteConfig& route : routes_between_all(topology.links)) {
    if (route.from != name && route.to != name) continue;
    route.rule = no_hil;
    routes.push_back(std::move(route));
  }
  return routes;
}

/// The given routes. `any` and lists give those from and to the link; an entry without such a route
/// is refused.
std::vector<RouteConfig> given_routes(const Topology& topology, const ConfigNode& list,
                                      const std::string& name) {
  std::vector<RouteConfig> routes;
  for (const ConfigNode& node : list.items()) {
    const std::size_t before = routes.size();
    for (RouteConfig& route : parse_route(node, topology.links)) {
      if (route.from != name && route.to != name) continue;
      const auto same = [&](const RouteConfig& other) {
        return other.from == route.from && other.to == route.to;
      };
      if (std::ranges::any_of(routes, same)) {
        node.fail("there is another route from '" + route.from + "' to '" + route.to + "'");
      }
      routes.push_back(std::move(route));
    }
    if (routes.size() == before) node.fail("has nothing to do with the new link '" + name + "'");
  }
  return routes;
}

}  // namespace

Topology with_link(Topology topology, const ConfigNode& request,
                   const std::vector<std::uint8_t>& vehicles) {
  const ConfigNode keys = with_endpoint(topology, request.at("entry"));
  const std::string name =
      topology.links.emplace_back(parse_new_link(topology, keys, vehicles)).name;
  const auto given = request.find("routes");
  std::vector<RouteConfig> routes =
      given ? given_routes(topology, *given, name) : usual_routes(topology, name);
  topology.routes.insert(topology.routes.end(), std::make_move_iterator(routes.begin()),
                         std::make_move_iterator(routes.end()));
  // Only the new link may change: a link with another configuration would be reopened.
  Topology paced = topology;
  pace_tight_lines(paced);
  if (paced.pace == Pace::kLockstep) paced.set_lockstep();
  topology.links.back() = paced.links.back();
  return topology;
}

Topology without_link(Topology topology, const std::string& name) {
  if (find_link(topology.links, name) == nullptr) {
    throw base::ConfigError("there is no link '" + name +
                            "'; links: " + base::joined(topology.links, ", ", &LinkConfig::name));
  }
  if (topology.links.size() == 1) {
    throw base::ConfigError("'" + name + "' is the only link; casd needs one");
  }
  std::erase_if(topology.links, [&](const LinkConfig& link) { return link.name == name; });
  std::erase_if(topology.routes,
                [&](const RouteConfig& route) { return route.from == name || route.to == name; });
  return topology;
}

}  // namespace cas::casd

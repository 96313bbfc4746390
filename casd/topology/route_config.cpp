// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/route_config.hpp"

#include <algorithm>
#include <optional>
#include <tuple>

#include "base/text.hpp"
#include "casd/topology/link_config.hpp"
#include "casd/topology/message_keys.hpp"
#include "casd/topology/rule_keys.hpp"

namespace cas::casd {
namespace {

using base::ConfigNode;
using base::key;
using base::ReadApart;

constexpr ReadApart kLinks{"a link, a list, or `any`"};

constexpr std::tuple kRouteKeys{
    base::required(key<&RouteConfig::from>("from", kLinks, "where packets come from")),
    base::required(key<&RouteConfig::to>("to", kLinks, "where they go")),
};

std::string listed(const std::vector<LinkConfig>& links) {
  return base::joined(links, ", ", &LinkConfig::name);
}

std::vector<std::string> parse_link_names(const base::ConfigNode& node,
                                          const std::vector<LinkConfig>& links) {
  std::vector<std::string> names;
  const auto add = [&](const base::ConfigNode& entry, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      entry.fail("link '" + name + "' is named twice");
    }
    names.push_back(name);
  };
  for (const base::ConfigNode& entry : one_or_many(node)) {
    const auto name = entry.as<std::string>();
    if (name == "any") {
      for (const LinkConfig& link : links) add(entry, link.name);
    } else if (find_link(links, name) != nullptr) {
      add(entry, name);
    } else {
      entry.fail("there is no link '" + name + "'; links are " + listed(links));
    }
  }
  return names;
}

/// Why there can be no route between two links; nothing: there can.
std::optional<std::string> why_no_route(const LinkConfig& from, const LinkConfig& to) {
  if (to.type == LinkType::kTlog) {
    return "nothing can be sent to '" + to.name + "', a log that is played";
  }
  if (!from.sniffer && !to.sniffer) return std::nullopt;
  return "'" + (from.sniffer ? from : to).name +
         "' is a sniffer: it gets every packet without a route, sends none";
}

}  // namespace

std::vector<RouteConfig> parse_route(const base::ConfigNode& node,
                                     const std::vector<LinkConfig>& links) {
  const auto from = parse_link_names(node.at("from"), links);
  const auto to = parse_link_names(node.at("to"), links);
  ForwardRule rule;
  base::read_keys(node, kRuleKeys, rule);
  node.reject_unused();

  // `any` and lists leave out the way back to the sender; spelt out, it links a server's peers.
  const bool single = from.size() == 1 && to.size() == 1;
  std::vector<RouteConfig> routes;
  for (const std::string& one : from) {
    for (const std::string& other : to) {
      const LinkConfig& source = *find_link(links, one);
      if (const auto reason = why_no_route(source, *find_link(links, other))) {
        if (single) node.fail(*reason);
        continue;
      }
      if (one != other) {
        routes.push_back({one, other, rule});
      } else if (single) {
        if (!is_server(source)) node.fail("only peers of a server can talk on one link");
        routes.push_back({one, other, rule});
      }
    }
  }
  return routes;
}

std::vector<RouteConfig> routes_between_all(const std::vector<LinkConfig>& links) {
  std::vector<RouteConfig> routes;
  for (const LinkConfig& from : links) {
    for (const LinkConfig& to : links) {
      if (from.name != to.name && !why_no_route(from, to))
        routes.push_back({from.name, to.name, {}});
    }
  }
  return routes;
}

std::string rule_text(const ForwardRule& rule) {
  std::string text;
  for_each_filter(rule, [&text](const auto& key, const auto& list) {
    if (!text.empty()) text += ", ";
    text += list.empty() ? "nothing" : key.words;
    if (!list.empty()) text.append(" ").append(key.kind.text(list));
  });
  return text.empty() ? "everything" : text;
}

std::vector<base::KeyRow> route_rows() {
  std::vector<base::KeyRow> rows;
  base::add_rows(kRouteKeys, RouteConfig{}, rows);
  base::add_rows(kRuleKeys, ForwardRule{}, rows);
  return rows;
}

}  // namespace cas::casd

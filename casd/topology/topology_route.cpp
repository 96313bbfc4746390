// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <string_view>

#include "base/config/config_whole.hpp"
#include "casd/topology/topology_parts.hpp"
#include "mavlink_gen/parser/diagnostics.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

std::vector<base::ConfigNode> one_or_many(const base::ConfigNode& node) {
  return node.is_list() ? node.items() : std::vector{node};
}

std::string listed(const std::vector<LinkConfig>& links) {
  std::string names;
  for (const LinkConfig& link : links) names += (names.empty() ? "" : ", ") + link.name;
  return names;
}

std::vector<std::string> parse_link_names(const base::ConfigNode& node,
                                          const std::vector<LinkConfig>& links) {
  std::vector<std::string> names;
  for (const base::ConfigNode& entry : one_or_many(node)) {
    const auto name = entry.as<std::string>();
    const auto known = [&](const LinkConfig& link) { return link.name == name; };
    if (name == "any") {
      for (const LinkConfig& link : links) names.push_back(link.name);
    } else if (std::any_of(links.begin(), links.end(), known)) {
      names.push_back(name);
    } else {
      entry.fail("there is no link '" + name + "'; links are " + listed(links));
    }
  }
  return names;
}

bool is_number(const std::string& text) {
  return !text.empty() && text.size() <= 8 &&
         text.find_first_not_of("0123456789") == std::string::npos;
}

[[noreturn]] void refuse_message(const base::ConfigNode& node, const std::string& text) {
  std::vector<std::string_view> names;
  for (const mav::MessageInfo& message : mav::public_table().all()) names.push_back(message.name);
  const std::string near = mav::xml::suggestion(text, names);
  node.fail("no public message has the name '" + text + "'" +
            (near.empty() ? "; give its number if it is private" : near));
}

// A message by its name or its number; numbers may be of dialects that we do not know.
std::uint32_t parse_message(const base::ConfigNode& node, const std::string& text) {
  if (is_number(text)) {
    const unsigned long id = std::stoul(text);
    if (id > 0xFFFFFF) node.fail(text + " is beyond the message ids (24 bits)");
    return static_cast<std::uint32_t>(id);
  }
  const mav::MessageInfo* known = mav::public_table().find(text);
  if (known == nullptr) refuse_message(node, text);
  return known->id;
}

RateRule parse_rate(const std::string& message, const base::ConfigNode& node) {
  RateRule rate{.message_id = parse_message(node, message)};
  if (!node.is_map()) {
    rate.max_hz = node.as<double>();
  } else {
    rate.max_hz = node.get_in("max_hz", 0, 0, 1e6);
    rate.every = base::get_whole_in<unsigned>(node, "every", 1, 1, 1'000'000);
  }
  if (rate.max_hz <= 0 && rate.every == 1) node.fail("needs max_hz above 0, or every above 1");
  return rate;
}

ForwardRule parse_rule(const base::ConfigNode& node) {
  ForwardRule rule;
  if (const auto allow = node.find("allow")) rule.allow = parse_messages(*allow);
  if (const auto block = node.find("block")) rule.block = parse_messages(*block);
  rule.allow_systems = parse_bytes(node, "allow_systems");
  rule.block_systems = parse_bytes(node, "block_systems");
  rule.allow_components = parse_bytes(node, "allow_components");
  rule.block_components = parse_bytes(node, "block_components");
  if (const auto rates = node.find("rates")) {
    for (const auto& [message, entry] : rates->entries()) {
      rule.rates.push_back(parse_rate(message, entry));
    }
  }
  return rule;
}

bool is_of_type(const std::vector<LinkConfig>& links, const std::string& name, LinkType type) {
  return std::any_of(links.begin(), links.end(), [&](const LinkConfig& link) {
    return link.name == name && link.type == type;
  });
}

bool is_server(const std::vector<LinkConfig>& links, const std::string& name) {
  return is_of_type(links, name, LinkType::kUdpServer) ||
         is_of_type(links, name, LinkType::kTcpServer);
}

}  // namespace

std::vector<std::uint32_t> parse_messages(const base::ConfigNode& node) {
  std::vector<std::uint32_t> ids;
  for (const base::ConfigNode& entry : one_or_many(node)) {
    ids.push_back(parse_message(entry, entry.as<std::string>()));
  }
  return ids;
}

std::vector<std::uint8_t> parse_bytes(const base::ConfigNode& node, std::string_view key) {
  std::vector<std::uint8_t> ids;
  const auto list = node.find(key);
  if (!list) return ids;
  for (const base::ConfigNode& entry : one_or_many(*list)) {
    const int id = entry.as<int>();
    if (id < 0 || id > 255) entry.fail(std::to_string(id) + " is not an id (0..255)");
    ids.push_back(static_cast<std::uint8_t>(id));
  }
  return ids;
}

std::vector<RouteConfig> parse_route(const base::ConfigNode& node,
                                     const std::vector<LinkConfig>& links) {
  const auto from = parse_link_names(node.at("from"), links);
  const auto to = parse_link_names(node.at("to"), links);
  const ForwardRule rule = parse_rule(node);
  node.reject_unused();

  // `any` and lists leave out the way back to the sender; spelt out, it links a server's peers.
  const bool single = from.size() == 1 && to.size() == 1;
  std::vector<RouteConfig> routes;
  for (const std::string& one : from) {
    for (const std::string& other : to) {
      if (is_of_type(links, other, LinkType::kTlog)) {
        if (single) node.fail("nothing can be sent to '" + other + "', a log that is played");
        continue;
      }
      if (one != other) {
        routes.push_back({one, other, rule});
      } else if (single) {
        if (!is_server(links, one)) node.fail("only peers of a server can talk on one link");
        routes.push_back({one, other, rule});
      }
    }
  }
  return routes;
}

}  // namespace cas::casd

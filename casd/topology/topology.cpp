// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>

#include "base/config/config.hpp"
#include "base/config/config_whole.hpp"
#include "base/config/install_paths.hpp"
#include "base/os/cpu_latency.hpp"
#include "casd/tlog/tlog_name.hpp"
#include "casd/topology/line_budget.hpp"

namespace cas::casd {
namespace {

constexpr int kSchema = 1;

ThreadModel parse_threads(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  for (const ThreadModel model :
       {ThreadModel::kPerLink, ThreadModel::kSingle, ThreadModel::kBlocking}) {
    if (word == to_string(model)) return model;
  }
  node.fail("'" + word + "' is none of per_link, single, blocking");
}

Pace parse_pace(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  if (word == "realtime") return Pace::kRealtime;
  if (word == "lockstep") return Pace::kLockstep;
  node.fail("'" + word + "' is none of realtime, lockstep");
}

std::uint8_t parse_id(const base::ConfigNode& root, std::string_view key, std::uint8_t fallback) {
  return base::get_whole_in<std::uint8_t>(root, key, fallback, 1, 255);
}

CommandPortConfig parse_command_port(const base::ConfigNode& node) {
  CommandPortConfig port;
  port.address = node.get<std::string>("address", port.address);
  port.port = base::get_whole_in<std::uint16_t>(node, "port", port.port, 0, 65535);
  if (const auto path = node.find("unix")) {
    const auto text = path->as<std::string>();
    if (text.empty()) path->fail("is empty; `none` means no Unix socket");
    port.unix_path = text == "none" ? "" : text;
  }
  if (const auto group = node.find("unix_group")) {
    port.unix_group = group->as<std::string>();
    if (port.unix_path && port.unix_path->empty()) group->fail("has no meaning with `unix: none`");
  }
  if (node.has("token_file"))
    port.token_file = node.resolve(node.require<std::string>("token_file"));
  port.loopback_without_token = node.get<bool>("loopback_without_token", false);
  return port;
}

MetricsConfig parse_metrics(const base::ConfigNode& node) {
  MetricsConfig metrics;
  metrics.address = node.get<std::string>("address", metrics.address);
  metrics.port = base::get_whole_in<std::uint16_t>(node, "port", metrics.port, 0, 65535);
  return metrics;
}

CommandingConfig parse_commanding(const base::ConfigNode& node) {
  CommandingConfig commanding;
  commanding.heartbeat_hz = node.get_in("heartbeat_hz", commanding.heartbeat_hz, 0, 100);
  commanding.allow_not_hil = node.get<bool>("allow_not_hil", false);
  return commanding;
}

/// A recording stops before the disk is full, where it would take others with it.
constexpr double kFreeSpaceMin_mib = 64;

std::uint64_t parse_mib(const base::ConfigNode& node, std::string_view key, double fallback) {
  return static_cast<std::uint64_t>(node.get_in(key, fallback, 0, 1e8) * 1024 * 1024);
}

TlogConfig parse_log(const base::ConfigNode& node) {
  TlogConfig log;
  if (const auto tlog = node.find("tlog")) {
    log.tlog = tlog->as<std::string>();
    const std::string fault = tlog_name_fault(log.tlog);
    if (!fault.empty()) {
      tlog->fail("'" + log.tlog + "' " + fault + "; it is a name, and its folder is `folder`");
    }
  }
  log.folder = node.get<std::string>("folder", default_tlog_folder());
  log.rotation.max_bytes = parse_mib(node, "rotate_mib", 0);
  log.rotation.max_age = base::from_seconds(node.get_in("rotate_minutes", 0, 0, 1e6) * 60);
  log.rotation.keep = base::get_whole_in<int>(node, "keep", 0, 0, 1'000'000);
  log.limits.max_bytes = parse_mib(node, "max_mib", 0);
  log.limits.free_space_min_bytes = parse_mib(node, "free_space_min_mib", kFreeSpaceMin_mib);
  log.while_armed = node.get<bool>("while_armed", false);
  log.overwrite = node.get<bool>("overwrite", false);
  if (log.overwrite && log.while_armed) {
    node.at("overwrite").fail("each flight of while_armed has a file of its own");
  }
  return log;
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

/// The routes of one entry of `routes`: `from` and `to` take a name, a list of names or `any`.
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

std::vector<LinkConfig> parse_links(const base::ConfigNode& root) {
  std::vector<LinkConfig> links;
  std::set<std::string> names;
  for (const base::ConfigNode& node : root.at("links").items()) {
    links.push_back(parse_link(node));
    if (!names.insert(links.back().name).second) {
      node.at("name").fail("'" + links.back().name + "' is the name of another link");
    }
    if (links.size() == static_cast<std::size_t>(kLocalLink)) node.fail("more than 62 links");
  }
  if (links.empty()) root.at("links").fail("no link");
  return links;
}

// Without a `routes` block every link talks to every other one.
std::vector<RouteConfig> routes_between_all(const std::vector<LinkConfig>& links) {
  std::vector<RouteConfig> routes;
  for (const LinkConfig& from : links) {
    for (const LinkConfig& to : links) {
      if (from.name != to.name && to.type != LinkType::kTlog)
        routes.push_back({from.name, to.name, {}});
    }
  }
  return routes;
}

std::vector<RouteConfig> parse_routes(const base::ConfigNode& root,
                                      const std::vector<LinkConfig>& links) {
  const std::optional<base::ConfigNode> block = root.find("routes");
  if (!block) return routes_between_all(links);
  std::vector<RouteConfig> routes;
  std::set<std::pair<std::string, std::string>> pairs;
  for (const base::ConfigNode& node : block->items()) {
    for (RouteConfig& route : parse_route(node, links)) {
      if (!pairs.insert({route.from, route.to}).second) {
        node.fail("there is another route from '" + route.from + "' to '" + route.to + "'");
      }
      routes.push_back(std::move(route));
    }
  }
  return routes;
}

// A pseudo-terminal has no rate of its own. It is held to its baud rate where that makes a
// difference to how old data gets: where the routes may send half of it or more.
void pace_tight_lines(Topology& topology) {
  constexpr double kTight = 0.5;
  for (const LineBudget& budget : line_budgets(topology)) {
    if (budget.load_bytes_s() < kTight * budget.capacity_bytes_s) continue;
    for (LinkConfig& link : topology.links) {
      if (link.name == budget.link && link.pace) link.pace_pty = true;
    }
  }
}

}  // namespace

std::string_view to_string(ThreadModel model) {
  switch (model) {
    case ThreadModel::kPerLink:
      return "per_link";
    case ThreadModel::kSingle:
      return "single";
    case ThreadModel::kBlocking:
      return "blocking";
  }
  return "?";
}

Topology Topology::load(const std::filesystem::path& file) {
  return parse(base::ConfigNode::load(file));
}

Topology Topology::parse(const base::ConfigNode& root) {
  if (const int schema = root.require<int>("schema"); schema != kSchema) {
    root.at("schema").fail("schema " + std::to_string(schema) + " is not 1");
  }
  Topology topology;
  topology.self = {parse_id(root, "system_id", topology.self.system),
                   parse_id(root, "component_id", topology.self.component)};
  if (const auto node = root.find("threads")) topology.threads = parse_threads(*node);
  const double tick_ms = 1e3 * base::to_seconds(topology.drain_tick);
  topology.drain_tick = base::from_seconds(1e-3 * root.get_in("drain_tick_ms", tick_ms, 0, 10));
  if (topology.drain_tick > base::Duration{} && topology.drain_tick < LineDrain::kLeastTick) {
    root.at("drain_tick_ms").fail("the kernel's tick is 0 (none) or at least 0.1 ms");
  }
  if (const auto node = root.find("scheduling")) {
    topology.scheduling = base::parse_thread_options(*node);
  }
  topology.lock_memory = root.get<bool>("lock_memory", false);
  topology.cpu_dma_latency_us = base::parse_cpu_latency(root);
  topology.route_lifetime = base::from_seconds(
      root.get_in("route_lifetime_s", base::to_seconds(topology.route_lifetime), 1, 86400));
  if (const auto node = root.find("command_port")) {
    topology.command_port = parse_command_port(*node);
  }
  if (const auto node = root.find("metrics")) topology.metrics = parse_metrics(*node);
  if (const auto node = root.find("commanding")) topology.commanding = parse_commanding(*node);
  topology.links = parse_links(root);
  topology.routes = parse_routes(root, topology.links);
  pace_tight_lines(topology);
  topology.log = parse_log(root.find("log").value_or(base::ConfigNode::empty()));
  if (const auto dialect = root.find("dialect")) topology.dialect = base::find_config(*dialect);
  if (const auto gains = root.find("gains")) topology.gains = base::find_config(*gains);
  if (const auto pace = root.find("pace"); pace && parse_pace(*pace) == Pace::kLockstep) {
    topology.set_lockstep();
  }
  root.reject_unused();
  return topology;
}

void Topology::set_lockstep() {
  constexpr base::Duration kNever = std::chrono::hours(24);
  pace = Pace::kLockstep;
  for (LinkConfig& link : links) {
    link.pace = false;
    link.queue.hil_max_age = link.queue.gps_max_age = kNever;
    link.queue.setpoint_max_age = link.queue.telemetry_max_age = kNever;
  }
}

std::vector<std::string> restart_keys(const Topology& in_force, const Topology& next) {
  const Topology& was = in_force;
  std::vector<std::string> keys;
  const auto compare = [&keys](const char* key, const auto& before, const auto& after) {
    if (before != after) keys.emplace_back(key);
  };
  compare("system_id", was.self.system, next.self.system);
  compare("component_id", was.self.component, next.self.component);
  compare("threads", was.threads, next.threads);
  compare("drain_tick_ms", was.drain_tick, next.drain_tick);
  compare("pace", was.pace, next.pace);
  compare("scheduling", was.scheduling, next.scheduling);
  compare("lock_memory", was.lock_memory, next.lock_memory);
  compare("cpu_dma_latency_us", was.cpu_dma_latency_us, next.cpu_dma_latency_us);
  compare("route_lifetime_s", was.route_lifetime, next.route_lifetime);
  compare("command_port", was.command_port, next.command_port);
  compare("metrics", was.metrics, next.metrics);
  compare("log", was.log, next.log);
  if (!keys.empty()) return keys;

  // A field that the list above forgets is refused too: only these are known to change in place.
  Topology fixed = next;
  fixed.links = was.links;
  fixed.routes = was.routes;
  fixed.commanding = was.commanding;
  fixed.dialect = was.dialect;
  fixed.gains = was.gains;
  if (fixed != was) keys.push_back("topology");
  return keys;
}

void refuse_restart_keys(const Topology& in_force, const Topology& next,
                         const base::ConfigNode& root) {
  const std::vector<std::string> keys = restart_keys(in_force, next);
  if (keys.empty()) return;
  if (const auto node = root.find(keys.front())) node->fail("takes a restart");
  root.fail(keys.front() + ": takes a restart");  // the key was taken out
}

}  // namespace cas::casd

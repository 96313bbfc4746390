// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology.hpp"

#include <algorithm>
#include <set>

#include "base/config/config_whole.hpp"
#include "base/config/install_paths.hpp"
#include "base/os/cpu_latency.hpp"
#include "casd/topology/line_budget.hpp"
#include "casd/topology/topology_parts.hpp"

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
  port.unix_path = node.get<std::string>("unix", "");
  if (node.has("token_file"))
    port.token_file = node.resolve(node.require<std::string>("token_file"));
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

TlogConfig parse_log(const base::ConfigNode& node) {
  TlogConfig log;
  log.tlog = node.get<std::string>("tlog", "");
  log.rotation.max_bytes =
      static_cast<std::uint64_t>(node.get_in("rotate_mib", 0, 0, 1e6) * 1024 * 1024);
  log.rotation.max_age = base::from_seconds(node.get_in("rotate_minutes", 0, 0, 1e6) * 60);
  log.rotation.keep = base::get_whole_in<int>(node, "keep", 0, 0, 1'000'000);
  log.overwrite = node.get<bool>("overwrite", false);
  return log;
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
  if (const auto log = root.find("log")) topology.log = parse_log(*log);
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
    link.queue.hil_max_age = link.queue.gps_max_age = link.queue.telemetry_max_age = kNever;
  }
}

}  // namespace cas::casd

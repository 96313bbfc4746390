// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/injection.hpp"

#include <algorithm>
#include <set>

#include "base/os/host_port.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {
namespace {

constexpr std::uint32_t kSensor = mavlink::common::HilSensor::kId;

bool holds(const std::vector<std::uint32_t>& messages, std::uint32_t id) {
  return std::find(messages.begin(), messages.end(), id) != messages.end();
}

/// Says in so many words that HIL_SENSOR goes this way.
bool names_sensors(const RouteConfig& route) {
  return route.rule.allow && holds(*route.rule.allow, kSensor);
}

bool lets_sensors_pass(const RouteConfig& route) {
  return !route.rule.allow && !holds(route.rule.block, kSensor);
}

const LinkConfig& named(const Topology& topology, const std::string& name) {
  return *find_link(topology.links, name);
}

/// Links that flight controllers are at.
std::set<std::string> controllers(const Topology& topology) {
  std::set<std::string> names;
  for (const LinkConfig& link : topology.links) {
    if (link.type == LinkType::kSerial) names.insert(link.name);
  }
  for (const RouteConfig& route : topology.routes) {
    if (names_sensors(route)) names.insert(route.to);
  }
  return names;
}

/// Listens on more than this machine.
bool is_open(const LinkConfig& link) {
  if (!link.remote.empty()) return false;
  const auto place = base::parse_host_port(link.local);
  return place && place->host != "localhost" && place->host != "::1" &&
         !place->host.starts_with("127.");
}

}  // namespace

bool may_inject_failures(const LinkConfig& link) {
  return link.inject_failures && (link.accept.may_accept(mavlink::common::CommandLong::kId) ||
                                  link.accept.may_accept(mavlink::common::CommandInt::kId));
}

std::vector<std::string> injection_warnings(const Topology& topology) {
  const std::set<std::string> flying = controllers(topology);
  std::vector<std::string> warnings;
  for (const RouteConfig& route : topology.routes) {
    if (!flying.contains(route.to) || flying.contains(route.from)) continue;
    if (!lets_sensors_pass(route) || !named(topology, route.from).accept.may_accept(kSensor))
      continue;
    warnings.push_back(
        "whoever is at link " + route.from + " can send HIL_SENSOR to " + route.to +
        ": if a ground station is there, give the link accept: {traffic: ground_station, "
        "block_systems: [ids of the vehicles]}; if the simulator is, let the route "
        "allow HIL_SENSOR by name");
  }
  for (const LinkConfig& link : topology.links) {
    if (!may_inject_failures(link) || !is_open(link)) continue;
    if (link.signing && link.signing->verify) continue;
    warnings.push_back("any host that reaches link " + link.name +
                       " may have failures strike in the simulator: let it listen on 127.0.0.1, or "
                       "give it signing, or take inject_failures away");
  }
  return warnings;
}

}  // namespace cas::casd

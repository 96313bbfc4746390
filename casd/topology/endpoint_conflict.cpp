// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/endpoint_conflict.hpp"

#include <algorithm>

#include "casd/topology/endpoint_address.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

bool is_datagram(const LinkConfig& link) {
  return link.type == LinkType::kUdp || link.type == LinkType::kUdpServer;
}

bool same_transport(const LinkConfig& a, const LinkConfig& b) {
  return is_datagram(a) == is_datagram(b);
}

bool on_different_devices(const LinkConfig& a, const LinkConfig& b) {
  return !a.interface.empty() && !b.interface.empty() && a.interface != b.interface;
}

bool sends_to_many(const LinkConfig& link) { return EndpointAddress(link.remote).is_many(); }

/// The kernel gives it only what its one peer sends.
bool is_connected(const LinkConfig& link) {
  return link.type == LinkType::kUdp && !link.remote.empty() && !sends_to_many(link);
}

/// Members of a group, and all who broadcast, share a port.
bool both_listen(const LinkConfig& a, const LinkConfig& b) {
  if (!same_transport(a, b) || on_different_devices(a, b)) return false;
  if (sends_to_many(a) && sends_to_many(b)) return false;
  return EndpointAddress(a.local).overlaps(EndpointAddress(b.local));
}

/// A link takes a packet with its own address and port for an echo of its own, and gets nothing of
/// a group that it has not joined.
bool knows_echo(const LinkConfig& from, const LinkConfig& to) {
  if (!sends_to_many(from) || !sends_to_many(to)) return false;
  const EndpointAddress group(from.remote);
  const EndpointAddress other_group(to.remote);
  if (group.is_multicast() && other_group.is_multicast() && !(group == other_group)) return true;
  return EndpointAddress(from.local) == EndpointAddress(to.local) && from.interface == to.interface;
}

bool sends_to(const LinkConfig& from, const LinkConfig& to) {
  if (!same_transport(from, to) || on_different_devices(from, to)) return false;
  if (to.sniffer || to.accept.read_only) return false;
  if (knows_echo(from, to)) return false;
  const EndpointAddress there(from.remote);
  if (!to.interface.empty() && there.is_loopback()) return false;
  if (&from != &to && is_connected(to) &&
      !EndpointAddress(from.local).hears(EndpointAddress(to.remote)))
    return false;
  return EndpointAddress(to.local).hears(there);
}

std::string returns(const LinkConfig& from, const LinkConfig& to) {
  const std::string listener = &from == &to ? "it" : "link '" + to.name + "'";
  return "link '" + from.name + "' sends to " + from.remote + ", where " + listener +
         " listens: each packet would come back";
}

}  // namespace

std::optional<std::string> endpoint_conflict(const LinkConfig& link,
                                             std::span<const LinkConfig> others) {
  if (sends_to(link, link)) return returns(link, link);
  for (const LinkConfig& other : others) {
    if (!link.device.empty() && link.device == other.device) {
      return "link '" + other.name + "' has the device " + other.device + " already";
    }
    if (both_listen(link, other)) {
      return "link '" + other.name + "' listens at " + other.local + " already";
    }
    if (sends_to(link, other)) return returns(link, other);
    if (sends_to(other, link)) return returns(other, link);
  }
  return std::nullopt;
}

const LinkConfig* link_to_same_peer(const LinkConfig& link, std::span<const LinkConfig> others) {
  if (link.remote.empty()) return nullptr;
  const auto same = std::ranges::find_if(others, [&link](const LinkConfig& other) {
    return link.type == other.type && link.local == other.local &&
           link.interface == other.interface && !other.remote.empty() &&
           EndpointAddress(link.remote) == EndpointAddress(other.remote);
  });
  return same == others.end() ? nullptr : &*same;
}

std::optional<std::string> endpoint_conflict(const LinkConfig& link,
                                             const CommandPortConfig& port) {
  if (link.type != LinkType::kTcpServer) return std::nullopt;
  if (!EndpointAddress(link.local).overlaps({port.address, port.port})) return std::nullopt;
  const bool v6 = port.address.find(':') != port.address.npos;
  return (v6 ? "[" + port.address + "]" : port.address) + ":" + std::to_string(port.port) +
         " is the command port; another one is `command_port: {port: N}` or --command-port N";
}

}  // namespace cas::casd

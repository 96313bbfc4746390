// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/endpoint_conflict.hpp"

#include <string_view>

#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

/// "HOST:PORT" in its parts; no port, or port 0, which takes a free one: empty.
struct Place {
  std::string_view host;
  std::string_view port;

  explicit Place(std::string_view text) {
    const std::size_t colon = text.rfind(':');
    if (colon == text.npos || text.substr(colon + 1) == "0") return;
    host = text.substr(0, colon);
    port = text.substr(colon + 1);
  }
  bool is_any() const { return host == "0.0.0.0" || host == "[::]" || host.empty(); }
  bool is_usual_loopback() const {
    return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
  }
  bool is_loopback() const { return is_usual_loopback() || host.starts_with("127."); }
  bool is_multicast_or_broadcast() const {
    const bool ipv4_group = host.size() > 3 && host >= "224." && host < "240." && host[3] == '.';
    return ipv4_group || host.starts_with("[ff") || host.ends_with(".255");
  }
  /// Whether a socket with this address gets what another one of the machine sends to `there`.
  bool hears(const Place& there) const {
    if (port.empty() || port != there.port) return false;
    return host == there.host || (is_usual_loopback() && there.is_usual_loopback()) ||
           (is_any() && (there.is_loopback() || there.is_multicast_or_broadcast()));
  }
  bool overlaps(const Place& other) const {
    if (port.empty() || port != other.port) return false;
    return host == other.host || is_any() || other.is_any();
  }
};

bool is_datagram(const LinkConfig& link) {
  return link.type == LinkType::kUdp || link.type == LinkType::kUdpServer;
}

/// The members of a group share its port, and know an echo of their own packets.
bool sends_to_many(const LinkConfig& link) {
  return Place(link.remote).is_multicast_or_broadcast();
}

bool both_listen(const LinkConfig& a, const LinkConfig& b) {
  if (is_datagram(a) != is_datagram(b) || (sends_to_many(a) && sends_to_many(b))) return false;
  return Place(a.local).overlaps(Place(b.local));
}

bool sends_to(const LinkConfig& from, const LinkConfig& to) {
  if (is_datagram(from) != is_datagram(to) || (sends_to_many(from) && sends_to_many(to)))
    return false;
  return Place(to.local).hears(Place(from.remote));
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
    if (both_listen(link, other)) {
      return "link '" + other.name + "' listens at " + other.local + " already";
    }
    if (sends_to(link, other)) return returns(link, other);
    if (sends_to(other, link)) return returns(other, link);
  }
  return std::nullopt;
}

std::optional<std::string> endpoint_conflict(const LinkConfig& link,
                                             const CommandPortConfig& port) {
  if (link.type != LinkType::kTcpServer) return std::nullopt;
  const std::string place = port.address + ":" + std::to_string(port.port);
  if (!Place(link.local).overlaps(Place(place))) return std::nullopt;
  return place +
         " is the command port; another one is `command_port: {port: N}` or --command-port N";
}

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace cas::casd {

/// Host and port of an endpoint as they are written, in any spelling: 127.1 and 0x7f000001 are
/// 127.0.0.1, as is ::ffff:127.0.0.1. Names are not looked up, but `localhost` and the name of this
/// machine are this machine in both address families.
class EndpointAddress {
 public:
  /// @param text  "HOST:PORT" with an IPv6 address in brackets; anything else is none
  explicit EndpointAddress(std::string_view text);
  /// @param host  an IPv6 address without brackets
  EndpointAddress(std::string host, unsigned port);

  bool is_name() const { return family_ == Family::kName; }
  bool is_loopback() const;
  /// The machine's own name: one of its addresses, whichever.
  bool is_own_name() const;
  bool is_any() const;  ///< 0.0.0.0 or ::
  /// Error for an address where nothing can be sent, with what people mean by it.
  static constexpr std::string_view kNoDestination =
      "is no destination: to listen there for whoever connects, make it `local` of a udp_server or "
      "tcp_server (udpin:, tcpin:); to send on this machine, write 127.0.0.1";
  bool is_multicast() const;
  /// A group, or what looks like the broadcast address of a network: it ends in .255.
  bool is_many() const;

  /// Whether sockets cannot be bound to both. Port 0 takes a free one and clashes with none.
  bool overlaps(const EndpointAddress& other) const;
  /// Whether a socket bound here gets what another one of this machine sends to `there`.
  bool hears(const EndpointAddress& there) const;

  friend bool operator==(const EndpointAddress&, const EndpointAddress&) = default;

 private:
  enum class Family : std::uint8_t { kName, kIpv4, kIpv6 };

  void read_ipv4(const void* address);
  bool same_host(const EndpointAddress& other) const;
  bool covers(const EndpointAddress& other) const;

  std::string host_;
  Family family_ = Family::kName;
  std::array<std::uint8_t, 16> bytes_{};  ///< of an address; IPv4 has four
  unsigned port_ = 0;
};

}  // namespace cas::casd

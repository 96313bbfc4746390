// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace cas::casd {

/// Host and port of an endpoint as they are written. Names are not looked up, but `localhost` is
/// this machine in both address families. Pure.
class EndpointAddress {
 public:
  /// @param text  "HOST:PORT" with an IPv6 address in brackets; anything else is none
  explicit EndpointAddress(std::string_view text);
  /// @param host  an IPv6 address without brackets
  EndpointAddress(std::string host, unsigned port);

  bool is_name() const { return family_ == Family::kName; }
  bool is_loopback() const;
  bool is_any() const;  ///< 0.0.0.0 or ::
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

  bool same_host(const EndpointAddress& other) const;
  bool covers(const EndpointAddress& other) const;

  std::string host_;
  Family family_ = Family::kName;
  std::array<std::uint8_t, 16> bytes_{};  ///< of an address; IPv4 has four
  unsigned port_ = 0;
};

}  // namespace cas::casd

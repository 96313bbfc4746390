// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/endpoint_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <climits>
#include <cstring>
#include <utility>

#include "base/os/host_port.hpp"
#include "base/text.hpp"

namespace cas::casd {
namespace {

constexpr std::string_view kLocalhost = "localhost";
constexpr std::array<std::string_view, 4> kLocalhosts{kLocalhost, "localhost.localdomain",
                                                      "ip6-localhost", "ip6-loopback"};
constexpr std::array<std::uint8_t, 16> kIpv6Loopback{0, 0, 0, 0, 0, 0, 0, 0,
                                                     0, 0, 0, 0, 0, 0, 0, 1};

/// A name in lower case, without the dot of the root; `localhost` for each of its names.
std::string plain_name(std::string_view name) {
  if (name.ends_with('.')) name.remove_suffix(1);
  const std::string lower = base::lower(name);
  return std::ranges::find(kLocalhosts, lower) == kLocalhosts.end() ? lower
                                                                    : std::string(kLocalhost);
}

std::string own_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? plain_name(name.data()) : "";
}

}  // namespace

EndpointAddress::EndpointAddress(std::string_view text) {
  const auto parts = base::parse_host_port(text);
  if (!parts) return;
  unsigned port = 0;
  std::from_chars(parts->port.data(), parts->port.data() + parts->port.size(), port);
  *this = EndpointAddress(parts->host, port);
}

EndpointAddress::EndpointAddress(std::string host, unsigned port)
    : host_(std::move(host)), port_(port) {
  const std::string without_device = host_.substr(0, host_.find('%'));
  in_addr v4{};
  in6_addr v6{};
  if (::inet_aton(host_.c_str(), &v4) != 0) {
    read_ipv4(&v4);
  } else if (::inet_pton(AF_INET6, without_device.c_str(), &v6) != 1) {
    host_ = plain_name(host_);
  } else if (IN6_IS_ADDR_V4MAPPED(&v6)) {
    read_ipv4(&v6.s6_addr[12]);
  } else {
    family_ = Family::kIpv6;
    std::memcpy(bytes_.data(), &v6, sizeof v6);
  }
}

/// With one spelling, so that equal addresses are equal.
void EndpointAddress::read_ipv4(const void* address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  family_ = Family::kIpv4;
  std::memcpy(bytes_.data(), address, sizeof(in_addr));
  host_ = ::inet_ntop(AF_INET, address, text.data(), text.size());
}

bool EndpointAddress::is_own_name() const {
  const std::string own = own_name();
  return is_name() && !own.empty() && (host_ == own || host_ == own + ".local");
}

bool EndpointAddress::is_loopback() const {
  switch (family_) {
    case Family::kName:
      return host_ == kLocalhost;
    case Family::kIpv4:
      return bytes_[0] == 127;
    case Family::kIpv6:
      return bytes_ == kIpv6Loopback;
  }
  return false;
}

bool EndpointAddress::is_any() const { return !is_name() && bytes_ == decltype(bytes_){}; }

bool EndpointAddress::is_multicast() const {
  return family_ == Family::kIpv4 ? (bytes_[0] & 0xF0U) == 0xE0
                                  : family_ == Family::kIpv6 && bytes_[0] == 0xFF;
}

bool EndpointAddress::is_many() const {
  return is_multicast() || (family_ == Family::kIpv4 && bytes_[3] == 255);
}

bool EndpointAddress::overlaps(const EndpointAddress& other) const {
  if (port_ == 0 || port_ != other.port_) return false;
  return same_host(other) || covers(other) || other.covers(*this);
}

bool EndpointAddress::hears(const EndpointAddress& there) const {
  if (port_ == 0 || port_ != there.port_) return false;
  // Packets to the wildcard address go to this machine.
  if (there.is_any()) return is_loopback() || is_any();
  return same_host(there) ||
         (covers(there) && (there.is_loopback() || there.is_own_name() || there.is_many()));
}

bool EndpointAddress::same_host(const EndpointAddress& other) const {
  if (host_ == other.host_) return true;
  if (!is_name() && !other.is_name()) return family_ == other.family_ && bytes_ == other.bytes_;
  return is_loopback() && other.is_loopback();  // one of them is the name
}

// A socket at [::] takes IPv4, too.
bool EndpointAddress::covers(const EndpointAddress& other) const {
  return is_any() && (family_ == Family::kIpv6 || other.family_ != Family::kIpv6);
}

}  // namespace cas::casd

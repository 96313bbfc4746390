// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/endpoint_address.hpp"

#include <arpa/inet.h>

#include <charconv>
#include <utility>

#include "base/os/host_port.hpp"

namespace cas::casd {
namespace {

constexpr std::string_view kLocalhost = "localhost";
constexpr std::array<std::uint8_t, 16> kIpv6Loopback{0, 0, 0, 0, 0, 0, 0, 0,
                                                     0, 0, 0, 0, 0, 0, 0, 1};

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
  if (::inet_pton(AF_INET, host_.c_str(), bytes_.data()) == 1) {
    family_ = Family::kIpv4;
  } else if (::inet_pton(AF_INET6, without_device.c_str(), bytes_.data()) == 1) {
    family_ = Family::kIpv6;
  }
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
  return same_host(there) || (covers(there) && (there.is_loopback() || there.is_many()));
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

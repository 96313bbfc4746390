// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/client_places.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace cas::base::rpc {
namespace {

constexpr const char* kLoopback = "loopback";

ClientOrigin v4_origin(const in_addr& address) {
  if ((ntohl(address.s_addr) >> 24U) == IN_LOOPBACKNET) {
    return {.share = kLoopback, .loopback = true};
  }
  std::array<char, INET_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET, &address, text.data(), text.size());
  return {.share = text.data()};
}

ClientOrigin v6_origin(const in6_addr& address) {
  if (IN6_IS_ADDR_LOOPBACK(&address)) return {.share = kLoopback, .loopback = true};
  if (IN6_IS_ADDR_V4MAPPED(&address)) {
    in_addr carried{};
    std::memcpy(&carried, &address.s6_addr[12], sizeof carried);
    return v4_origin(carried);
  }
  in6_addr network = address;  // one household or laboratory has a network of 64 bits
  std::fill(std::begin(network.s6_addr) + 8, std::end(network.s6_addr), std::uint8_t{0});
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET6, &network, text.data(), text.size());
  return {.share = std::string(text.data()) + "/64"};
}

}  // namespace

ClientOrigin tcp_origin(const sockaddr& address) {
  if (address.sa_family == AF_INET) {
    return v4_origin(reinterpret_cast<const sockaddr_in&>(address).sin_addr);
  }
  if (address.sa_family == AF_INET6) {
    return v6_origin(reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
  }
  return {.share = "?"};
}

ClientOrigin unix_origin(uid_t client, uid_t server) {
  return {.share = "uid " + std::to_string(client),
          .over_unix = true,
          .is_operator = client == 0 || client == server};
}

namespace {

/// The client that makes room for another one: the oldest silent one, else the oldest that has
/// asked nothing. @param may_go  whether a client may be chosen
template <class MayGo>
std::optional<std::size_t> oldest_stranger(std::span<const PlaceHolder> holders, MayGo may_go) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < holders.size(); ++i) {
    if (holders[i].asked || !may_go(holders[i])) continue;
    if (!holders[i].spoke) return i;
    if (!found) found = i;
  }
  return found;
}

PlaceDecision displace_or_refuse(std::optional<std::size_t> displaced, const char* refusal) {
  if (displaced) return {.displaced = displaced};
  return {.refusal = refusal};
}

}  // namespace

PlaceDecision find_place(const ClientOrigin& client, std::span<const PlaceHolder> holders,
                         std::size_t places, bool keep_one) {
  constexpr const char* kAllTaken = "the server has as many clients as it takes";
  if (client.is_operator) {
    if (holders.size() < places) return {};
    return displace_or_refuse(oldest_stranger(holders, [](const PlaceHolder&) { return true; }),
                              kAllTaken);
  }
  const auto is_own = [&client](const PlaceHolder& each) {
    return each.origin.share == client.share;
  };
  if (static_cast<std::size_t>(std::ranges::count_if(holders, is_own)) >= (places + 1) / 2) {
    return displace_or_refuse(oldest_stranger(holders, is_own),
                              client.over_unix
                                  ? "the server has as many clients of one user as it takes"
                                  : "the server has as many clients of one address as it takes");
  }
  if (holders.size() + (keep_one ? 1 : 0) < places) return {};
  return displace_or_refuse(
      oldest_stranger(holders, [](const PlaceHolder& each) { return !each.origin.is_operator; }),
      kAllTaken);
}

}  // namespace cas::base::rpc

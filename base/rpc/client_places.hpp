// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>
#include <sys/types.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace cas::base::rpc {

/// Where a client comes from, as far as places and rights depend on it.
struct ClientOrigin {
  /// Clients with the same word have one share: "loopback", "192.0.2.7", "2001:db8:1:2::/64",
  /// "uid 1000".
  std::string share{};
  bool over_unix = false;
  bool loopback = false;  ///< TCP from this machine
  /// On a Unix socket, as root or as the server's own user.
  bool is_operator = false;
};

/// Origin of a TCP client: all of 127.0.0.0/8 and ::1 are one share, an IPv6 network of 64 bits is
/// one, and an IPv4 address that IPv6 carries is the IPv4 address. Another family is the share "?".
ClientOrigin tcp_origin(const sockaddr& address);
/// Origin of a client on a Unix socket. @param server  the user that the server runs as
ClientOrigin unix_origin(uid_t client, uid_t server);

/// A client that has a place.
struct PlaceHolder {
  ClientOrigin origin;
  bool asked = false;  ///< it has made a request, authorised where that is asked for
  bool spoke = false;  ///< it has sent a line
};

/// Decision on a new client.
struct PlaceDecision {
  std::optional<std::string> refusal{};    ///< why it gets no place; nullopt: it gets one
  std::optional<std::size_t> displaced{};  ///< the holder that must go for it
};

/// Shares out `places`. A share takes at most half of them. With `keep_one` the last place is for
/// an operator, who has no such limit. Where there is none, a client displaces one that has asked
/// nothing: of its own share if that is full, else of any but an operator's; an operator displaces
/// any. The silent go before those that have sent a line, the oldest first. Who has asked keeps its
/// place. Pure.
/// @param holders  in the order in which they came
PlaceDecision find_place(const ClientOrigin& client, std::span<const PlaceHolder> holders,
                         std::size_t places, bool keep_one);

}  // namespace cas::base::rpc

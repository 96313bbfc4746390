// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"

namespace cas::casd {

/// An IPv4 or IPv6 address with its port.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  int family() const { return storage.ss_family; }
  bool is_multicast() const;
  bool is_ipv4_broadcast() const;  ///< 255.255.255.255
  std::uint16_t port() const;
  void set_port(std::uint16_t port);

  friend bool operator==(const SocketAddress& a, const SocketAddress& b) {
    return a.size == b.size && std::memcmp(&a.storage, &b.storage, a.size) == 0;
  }
};

/// Where a datagram came from, and over which of its link's sockets.
struct PeerAddress {
  SocketAddress address;
  std::uint8_t socket = 0;

  friend bool operator==(const PeerAddress&, const PeerAddress&) = default;
};

/// "127.0.0.1:14550", "[::1]:14550".
std::string to_text(const SocketAddress& address);
/// The address a socket is bound to.
SocketAddress local_address(int fd);

/// Sockets at every address of a name, all at one port: `localhost` is ::1 and 127.0.0.1.
struct OpenSockets {
  std::vector<base::Descriptor> sockets{};
  int error = 0;  ///< why there are none, an errno
};
/// @param open  opens a socket and binds it to the address; empty with errno
template <class Open>
OpenSockets open_at_each(std::span<const SocketAddress> addresses, Open&& open) {
  OpenSockets all;
  for (SocketAddress address : addresses) {
    if (!all.sockets.empty()) address.set_port(local_address(all.sockets.front().get()).port());
    base::Descriptor socket = open(address);
    if (socket) {
      all.sockets.push_back(std::move(socket));
      continue;
    }
    all.error = errno;
    // A machine without IPv6, for example, lacks the one address only.
    if (all.error != EADDRNOTAVAIL && all.error != EAFNOSUPPORT) {
      all.sockets.clear();
      break;
    }
  }
  return all;
}
/// Where they are bound: "127.0.0.1:14550", or several with `and` between.
std::string to_text(std::span<const int> sockets);
/// Their numbers, for those who do not own them.
std::vector<int> numbers_of(std::span<const base::Descriptor> sockets);

/// Finds the addresses of "HOST:PORT". Numbers are read at once; names are looked up on a thread of
/// their own, so that a slow name server never holds up a link.
class AddressLookup {
 public:
  AddressLookup() = default;
  explicit AddressLookup(const std::string& endpoint);

  enum class State { kPending, kFound, kFailed };
  State state() const;
  /// Whether it is a name, which may stand for other addresses later.
  bool is_name() const { return shared_ && shared_->is_name; }
  /// Valid in state kFound: the first one.
  const SocketAddress& address() const { return addresses().front(); }
  /// Likewise all, at most kMost, in the order in which the machine prefers them.
  const std::vector<SocketAddress>& addresses() const;
  static constexpr std::size_t kMost = 8;
  /// Why it failed.
  std::string error() const;

 private:
  struct Shared {
    std::atomic<State> state{State::kPending};
    bool is_name = false;
    std::vector<SocketAddress> addresses;
    std::string error;
  };
  std::shared_ptr<Shared> shared_;
};

}  // namespace cas::casd

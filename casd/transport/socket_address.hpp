// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

namespace cas::casd {

/// An IPv4 or IPv6 address with its port.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  int family() const { return storage.ss_family; }
  bool is_multicast() const;
  bool is_ipv4_broadcast() const;  ///< 255.255.255.255

  friend bool operator==(const SocketAddress& a, const SocketAddress& b) {
    return a.size == b.size && std::memcmp(&a.storage, &b.storage, a.size) == 0;
  }
};

/// "127.0.0.1:14550", "[::1]:14550".
std::string to_text(const SocketAddress& address);
/// The address a socket is bound to.
SocketAddress local_address(int fd);

/// Finds the address of "HOST:PORT". Numbers are read at once; names are looked up on a thread of
/// their own, so that a slow name server never holds up a link.
class AddressLookup {
 public:
  AddressLookup() = default;
  explicit AddressLookup(const std::string& endpoint);

  enum class State { kPending, kFound, kFailed };
  State state() const;
  /// Valid in state kFound.
  const SocketAddress& address() const;
  /// Why it failed.
  std::string error() const;

 private:
  struct Shared {
    std::atomic<State> state{State::kPending};
    SocketAddress address;
    std::string error;
  };
  std::shared_ptr<Shared> shared_;
};

}  // namespace cas::casd

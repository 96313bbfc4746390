// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_link.hpp"

#include <net/if.h>
#include <netinet/in.h>

#include <cerrno>
#include <memory>
#include <string>
#include <utility>

#include "base/os/descriptor.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/transport/udp_socket.hpp"

namespace cas::casd {
namespace {

class UdpWriter final : public PacketWriter {
 public:
  /// @param to  nothing for a connected socket
  UdpWriter(base::Descriptor descriptor, const SocketAddress& to)
      : descriptor_(std::move(descriptor)), to_(to) {}

  WriteResult write(std::span<const PacketRef> packets) override {
    const auto result =
        sender_.send(descriptor_.get(), packets, to_.size == 0 ? nullptr : to_.get(), to_.size);
    unsent_.clear();
    for (const std::size_t index : result.refused) unsent_.push_back({index, DropCause::kClosed});
    return {.packets = result.packets,
            .broken = result.error != 0 && result.error != EAGAIN,
            .done = base::steady_now(),
            .refused_earlier = result.refused_earlier,
            .unsent = unsent_};
  }
  int descriptor() const override { return descriptor_.get(); }

 private:
  base::Descriptor descriptor_;
  SocketAddress to_;
  DatagramSender sender_;
  std::vector<Unsent> unsent_;
};

// Everybody's address, or that of a subnet: the kernel knows which addresses are one, and connects
// to them only with SO_BROADCAST.
bool is_broadcast(const SocketAddress& remote) {
  if (remote.is_ipv4_broadcast()) return true;
  const base::Descriptor probe(::socket(remote.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0));
  return probe && ::connect(probe.get(), remote.get(), remote.size) != 0 && errno == EACCES;
}

// The kernel would choose the port with the first packet that is sent; nobody could answer before.
bool bind_to_any_port(int fd, int family) {
  SocketAddress any;
  any.storage.ss_family = static_cast<sa_family_t>(family);
  any.size = family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
  return ::bind(fd, any.get(), any.size) == 0;
}

// Hears the group and speaks to it on this device; with an empty name on the one that the routes
// lead to.
bool join_group(int fd, const SocketAddress& group, const std::string& interface) {
  const unsigned device = interface.empty() ? 0 : ::if_nametoindex(interface.c_str());
  if (group.family() == AF_INET) {
    ip_mreqn request{};
    request.imr_multiaddr = reinterpret_cast<const sockaddr_in&>(group.storage).sin_addr;
    request.imr_ifindex = static_cast<int>(device);
    const int only_joined = 0;
    ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &only_joined, sizeof only_joined);
    return ::setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0 &&
           (device == 0 ||
            ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request) == 0);
  }
  ipv6_mreq request{};
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(group.storage);
  request.ipv6mr_multiaddr = v6.sin6_addr;
  request.ipv6mr_interface = device != 0 ? device : v6.sin6_scope_id;
  const unsigned through = request.ipv6mr_interface;
  return ::setsockopt(fd, IPPROTO_IPV6, IPV6_JOIN_GROUP, &request, sizeof request) == 0 &&
         (through == 0 ||
          ::setsockopt(fd, IPPROTO_IPV6, IPV6_MULTICAST_IF, &through, sizeof through) == 0);
}

// The address that our packets to `remote` bear, with the port of `fd`.
SocketAddress source_towards(const SocketAddress& remote, int fd, const std::string& interface) {
  const base::Descriptor probe(open_udp_socket(remote.family(), interface));
  const int on = 1;
  ::setsockopt(probe.get(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  if (!probe || ::connect(probe.get(), remote.get(), remote.size) != 0) return {};
  SocketAddress source = local_address(probe.get());
  const SocketAddress bound = local_address(fd);
  if (source.family() == AF_INET) {
    reinterpret_cast<sockaddr_in&>(source.storage).sin_port =
        reinterpret_cast<const sockaddr_in&>(bound.storage).sin_port;
  } else {
    reinterpret_cast<sockaddr_in6&>(source.storage).sin6_port =
        reinterpret_cast<const sockaddr_in6&>(bound.storage).sin6_port;
  }
  return source;
}

}  // namespace

void UdpLink::open(base::RunTime now) {
  if (!look_up(now)) return;
  const SocketAddress& remote = remote_.address();
  base::Descriptor socket(open_udp_socket(remote.family(), core_.config().interface));
  if (!socket || !prepare(socket.get(), remote)) {
    return core_.went_down(error_text(errno), now);
  }
  begin(std::make_unique<UdpWriter>(std::move(socket), to_many_ ? remote : SocketAddress{}), now);
}

// Addresses are looked up anew at each opening: names may move.
bool UdpLink::look_up(base::RunTime now) {
  using enum AddressLookup::State;
  if (!looking_up_) {
    remote_ = AddressLookup(core_.config().remote);
    if (!core_.config().local.empty()) local_ = AddressLookup(core_.config().local);
    looking_up_ = true;
  }
  const bool has_local = !core_.config().local.empty();
  for (const AddressLookup* lookup : {&remote_, has_local ? &local_ : &remote_}) {
    if (lookup->state() == kFound) continue;
    if (lookup->state() == kFailed) {
      looking_up_ = false;
      core_.went_down(lookup->error(), now);
    } else {
      core_.backoff().failed(now);
    }
    return false;
  }
  looking_up_ = false;
  return true;
}

bool UdpLink::prepare(int fd, const SocketAddress& remote) {
  to_many_ = remote.is_multicast() || is_broadcast(remote);
  const int on = 1;
  if (!core_.config().local.empty()) {
    if (to_many_) ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    const SocketAddress& local = local_.address();
    if (::bind(fd, local.get(), local.size) != 0) return false;
  }
  if (!to_many_) return ::connect(fd, remote.get(), remote.size) == 0;
  ::setsockopt(fd, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  if (core_.config().local.empty() && !bind_to_any_port(fd, remote.family())) return false;
  const std::string& interface = core_.config().interface;
  if (remote.is_multicast() && !join_group(fd, remote, interface)) return false;
  own_ = source_towards(remote, fd, interface);
  return true;
}

void UdpLink::take_datagram(std::size_t index, base::RunTime now) {
  if (is_own(index)) return;
  packets_.take(
      core_.ingress(), reader_.sender(index), [this] { return !to_many_; }, reader_.datagram(index),
      now,
      [&](const mav::PacketView& packet) {
        core_.ingress().take_packet(packet, now, {}, reader_.waited(index));
      });
}

void UdpLink::take_held(const SocketAddress&, const mav::PacketView& packet, base::RunTime now) {
  core_.ingress().take_packet(packet, now);
}

bool UdpLink::is_own(std::size_t index) const {
  return to_many_ && own_.size > 0 && own_ == reader_.sender(index);
}

}  // namespace cas::casd

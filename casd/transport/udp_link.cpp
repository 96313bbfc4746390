// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_link.hpp"

#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/transport/udp_socket.hpp"

namespace cas::casd {
namespace {

class UdpWriter final : public PacketWriter {
 public:
  /// @param to  nothing for a connected socket
  UdpWriter(base::Descriptor descriptor, const SocketAddress& to,
            std::shared_ptr<LinkCounters> counters)
      : descriptor_(std::move(descriptor)), to_(to), counters_(std::move(counters)) {}

  WriteResult write(std::span<const PacketRef> packets) override {
    const auto result =
        sender_.send(descriptor_.get(), packets, to_.size == 0 ? nullptr : to_.get(), to_.size);
    counters_->note_send(result.refusal);
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
  std::shared_ptr<LinkCounters> counters_;
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
  source.set_port(local_address(fd).port());
  return source;
}

}  // namespace

void UdpLink::open(base::RunTime now) {
  if (!look_up(now)) return;
  choice_ = AddressChoice(remote_.addresses().size());
  last_second();
  base::Descriptor socket = open_socket();
  if (!socket) return core_.went_down(base::error_text(errno), now);
  const int fd = socket.get();
  begin(writer_of(std::move(socket)), {&fd, 1}, now);
}

base::Descriptor UdpLink::open_socket() {
  do {
    base::Descriptor socket(open_udp_socket(remote().family(), core_.config().interface));
    if (socket && prepare(socket.get(), remote())) return socket;
  } while (choice_.leave());
  return {};
}

std::unique_ptr<PacketWriter> UdpLink::writer_of(base::Descriptor socket) const {
  return std::make_unique<UdpWriter>(std::move(socket), to_many_ ? remote() : SocketAddress{},
                                     core_.shared_counters());
}

void UdpLink::on_second(base::RunTime now) {
  const AddressChoice::Second second = last_second();
  if (again_) return compare_addresses(now);
  if (!remote_.is_name()) return;
  const AddressChoice::Step step = choice_.on_second(second);
  switch (step) {
    case AddressChoice::Step::kStay:
      return;
    case AddressChoice::Step::kNext:
      return move_to_choice(now);
    case AddressChoice::Step::kLookUp:
    case AddressChoice::Step::kCompare:
      again_ = AddressLookup(core_.config().remote);
      begins_anew_ = step == AddressChoice::Step::kLookUp;
  }
}

AddressChoice::Second UdpLink::last_second() {
  const LinkCounters& counters = core_.counters();
  constexpr auto kRefused = static_cast<std::size_t>(DropCause::kClosed);
  const std::uint64_t heard = counters.rx.bytes.get();
  const std::uint64_t sent = counters.tx.packets.get();
  const std::uint64_t refused = counters.tx.refused.get() + counters.tx.dropped[kRefused].get();
  return {.heard = std::exchange(heard_, heard) != heard,
          .sent = std::exchange(sent_, sent) != sent,
          .refused = std::exchange(refused_, refused) != refused};
}

void UdpLink::move_to_choice(base::RunTime now) {
  let_go(now);  // a configured `local` is free only then
  base::Descriptor socket = open_socket();
  if (!socket) return core_.went_down(base::error_text(errno), now);
  const int fd = socket.get();
  replace(writer_of(std::move(socket)), {&fd, 1}, now);
  core_.counters().set_endpoint(to_text(local_address(fd)));
}

/// Takes the result of a new look-up, after refusals or a silence: the name may lead elsewhere now.
void UdpLink::compare_addresses(base::RunTime now) {
  if (again_->state() == AddressLookup::State::kPending) return;
  const AddressLookup found = *std::exchange(again_, std::nullopt);
  if (found.state() == AddressLookup::State::kFailed) return;
  const bool same = found.addresses() == remote_.addresses();
  if (same && !begins_anew_) return;
  remote_ = found;
  choice_ = AddressChoice(remote_.addresses().size());
  if (!same || choice_.count() > 1) move_to_choice(now);
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
    const auto local = std::ranges::find(local_.addresses(), remote.family(),
                                         [](const SocketAddress& each) { return each.family(); });
    if (local == local_.addresses().end()) {
      errno = EAFNOSUPPORT;
      return false;
    }
    if (::bind(fd, local->get(), local->size) != 0) return false;
  }
  if (!to_many_) return ::connect(fd, remote.get(), remote.size) == 0;
  ::setsockopt(fd, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  if (core_.config().local.empty() && !bind_to_any_port(fd, remote.family())) return false;
  const std::string& interface = core_.config().interface;
  if (remote.is_multicast() && !join_group(fd, remote, interface)) return false;
  own_ = source_towards(remote, fd, interface);
  return true;
}

void UdpLink::take_datagram(const DatagramReader& reader, std::size_t index, base::RunTime now) {
  if (is_own(reader.sender(index).address)) return;
  packets_.take(
      core_.ingress(), reader.sender(index), [this] { return !to_many_; }, reader.datagram(index),
      now,
      [&](const mav::PacketView& packet) {
        core_.ingress().take_packet(packet, now, {}, reader.waited(index));
      });
}

void UdpLink::take_held(const PeerAddress&, const mav::PacketView& packet, base::RunTime now) {
  core_.ingress().take_packet(packet, now);
}

bool UdpLink::is_own(const SocketAddress& sender) const {
  return to_many_ && own_.size > 0 && own_ == sender;
}

}  // namespace cas::casd

// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>

#include "casd/transport/datagram_link.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// UDP to one fixed remote: a simulator, a ground station, a broadcast or multicast group.
///
/// To a single host the socket is connected, so the kernel lets in only what that host sends.
class UdpLink final : public DatagramLink {
 public:
  explicit UdpLink(LinkContext context) : DatagramLink(std::move(context)) {}

 private:
  void open(base::RunTime now) override;
  void take_datagram(std::size_t index, base::RunTime now) override;
  void take_held(const SocketAddress& sender, const mav::PacketView& packet,
                 base::RunTime now) override;
  bool look_up(base::RunTime now);
  bool prepare(int fd, const SocketAddress& remote);
  bool is_own(std::size_t index) const;

  AddressLookup remote_;
  AddressLookup local_;
  bool looking_up_ = false;
  bool to_many_ = false;  ///< broadcast or multicast: not connected
  SocketAddress own_;     ///< where our own packets to the group come from
};

}  // namespace cas::casd

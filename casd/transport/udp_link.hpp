// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "base/os/descriptor.hpp"
#include "casd/transport/address_choice.hpp"
#include "casd/transport/datagram_link.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// UDP to one fixed remote: a simulator, a ground station, a broadcast or multicast group.
///
/// To a single host the socket is connected, so the kernel lets in only what that host sends. Of a
/// name with several addresses the one that answers is used, and a name is looked up again when its
/// addresses refuse packets for seconds.
class UdpLink final : public DatagramLink {
 public:
  explicit UdpLink(LinkContext context) : DatagramLink(std::move(context)) {}

 private:
  void open(base::RunTime now) override;
  void take_datagram(const DatagramReader& reader, std::size_t index, base::RunTime now) override;
  void take_held(const PeerAddress& sender, const mav::PacketView& packet,
                 base::RunTime now) override;
  bool look_up(base::RunTime now);
  void on_second(base::RunTime now) override;
  AddressChoice::Second last_second();
  /// A socket for the chosen address, or for the next one that a socket can be opened for.
  /// @return empty with errno
  base::Descriptor open_socket();
  bool prepare(int fd, const SocketAddress& remote);
  std::unique_ptr<PacketWriter> writer_of(base::Descriptor socket) const;
  void move_to_choice(base::RunTime now);
  void compare_addresses(base::RunTime now);
  const SocketAddress& remote() const { return remote_.addresses()[choice_.current()]; }
  bool is_own(const SocketAddress& sender) const;

  AddressLookup remote_;
  AddressLookup local_;
  bool looking_up_ = false;
  AddressChoice choice_;
  std::optional<AddressLookup> again_;  ///< the new look-up after refusals or a silence
  bool begins_anew_ = false;            ///< also where again_ finds the same
  std::uint64_t heard_ = 0;             ///< bytes, up to the last second
  std::uint64_t sent_ = 0;              ///< packets
  std::uint64_t refused_ = 0;           ///< packets
  bool to_many_ = false;                ///< broadcast or multicast: not connected
  SocketAddress own_;                   ///< where our own packets to the group come from
};

}  // namespace cas::casd

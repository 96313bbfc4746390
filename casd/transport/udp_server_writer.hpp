// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/transport/datagram_sender.hpp"
#include "casd/transport/udp_server_link.hpp"

namespace cas::casd {

/// Sends each packet to the peers that are to have it. What the socket does not take at once is
/// lost for that peer and counted: a queue per peer would only hold old packets.
class UdpServerWriter final : public PacketWriter {
 public:
  UdpServerWriter(base::Descriptor descriptor, LinkId own, std::shared_ptr<SharedPeers> peers,
                  std::shared_ptr<LinkCounters> counters);

  WriteResult write(std::span<const PacketRef> packets) override;
  std::ptrdiff_t write_rest(std::span<const std::uint8_t>) override { return 0; }
  int descriptor() const override { return descriptor_.get(); }

 private:
  void send_to_each(const PacketRef& packet, LinkMask peers);
  void send_by_peer(std::span<const PacketRef> packets);

  base::Descriptor descriptor_;
  LinkId own_;
  std::shared_ptr<SharedPeers> peers_;
  std::shared_ptr<LinkCounters> counters_;
  DatagramSender sender_;
  std::vector<LinkMask> masks_;
  std::vector<PacketRef> of_peer_;
};

}  // namespace cas::casd

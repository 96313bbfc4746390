// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "casd/link/link_core.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/transport/datagram_packets.hpp"
#include "casd/transport/udp_socket.hpp"

namespace cas::casd {

/// Base of both UDP links: reads the socket in batches, opens it again after a failure, and sends
/// through a TxPort.
class DatagramLink : public Link {
 public:
  ~DatagramLink() override { port_->detach(base::steady_now()); }

  void watch(PollSet& set, base::RunTime now) final;
  void serve(const PollSet& set, base::RunTime now) final;
  std::uint64_t received() const final { return core_.received(); }
  Arrivals arrivals() const final { return reader_.arrivals(); }
  std::shared_ptr<PacketPort> port() final { return port_; }

 protected:
  explicit DatagramLink(LinkContext context);

  /// Tries to open the socket; calls begin(), or tells the core why not.
  virtual void open(base::RunTime now) = 0;
  /// One datagram of the reader's last batch.
  virtual void take_datagram(std::size_t index, base::RunTime now) = 0;
  /// A packet that waited between two halves.
  virtual void take_held(const SocketAddress& sender, const mav::PacketView& packet,
                         base::RunTime now) = 0;
  virtual void on_second(base::RunTime) {}
  /// Packets go both ways from now on. @param writer  owns the open socket
  void begin(std::unique_ptr<PacketWriter> writer, base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  DatagramReader reader_;
  DatagramPackets packets_;

 private:
  void read(base::RunTime now);
  void release_held(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  OpenDescriptor fd_;  ///< owned by the port's writer
  std::uint32_t drops_seen_ = 0;
  std::size_t poll_entry_ = 0;
};

}  // namespace cas::casd

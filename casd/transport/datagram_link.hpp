// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

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
  Arrivals arrivals() const final;
  std::shared_ptr<PacketPort> port() final { return port_; }

 protected:
  explicit DatagramLink(LinkContext context);

  /// Tries to open the socket; calls begin(), or tells the core why not.
  virtual void open(base::RunTime now) = 0;
  /// One datagram of a reader's last batch. The number of its socket is that of begin().
  virtual void take_datagram(const DatagramReader& reader, std::size_t index,
                             base::RunTime now) = 0;
  /// A packet that waited between two halves.
  virtual void take_held(const PeerAddress& sender, const mav::PacketView& packet,
                         base::RunTime now) = 0;
  virtual void on_second(base::RunTime) {}
  /// Packets go both ways from now on. @param writer  owns the open sockets
  void begin(std::unique_ptr<PacketWriter> writer, std::span<const int> sockets, base::RunTime now);
  /// The same over other sockets than before, without the link going down.
  void replace(std::unique_ptr<PacketWriter> writer, std::span<const int> sockets,
               base::RunTime now);

  /// Closes the sockets; the link's state stays.
  void let_go(base::RunTime now);

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  DatagramPackets packets_;

 private:
  struct Socket {
    Socket(int open, std::uint8_t number) : fd(open), reader(number) {}
    OpenDescriptor fd;  ///< owned by the port's writer
    std::size_t poll_entry = 0;
    std::uint32_t drops_seen = 0;
    DatagramReader reader;
  };

  bool is_open() const { return !sockets_.empty(); }
  void read(Socket& socket, base::RunTime now);
  void release_held(base::RunTime now);
  /// Once a second: a link of which nothing may be sent is not up, though it receives.
  void judge_sending(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  std::vector<std::unique_ptr<Socket>> sockets_;
  int denied_ = 0;            ///< errno for which the link counts as down; 0: none
  std::uint64_t sent_ = 0;    ///< packets, up to the last second
  Arrivals closed_arrivals_;  ///< of sockets that are closed
};

}  // namespace cas::casd

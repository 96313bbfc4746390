// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "base/os/mutex.hpp"
#include "casd/link/link_core.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/transport/peer_table.hpp"
#include "casd/transport/socket_address.hpp"
#include "casd/transport/udp_socket.hpp"

namespace cas::casd {

/// UDP to one fixed remote: a simulator, a ground station, a broadcast or multicast group.
///
/// To a single host the socket is connected, so the kernel lets in only what that host sends.
class UdpLink final : public Link {
 public:
  explicit UdpLink(LinkContext context);
  ~UdpLink() override { port_->detach(base::steady_now()); }

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  Arrivals arrivals() const override { return reader_.arrivals(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void open(base::RunTime now);
  bool look_up(base::RunTime now);
  bool prepare(int fd, const SocketAddress& remote);
  void read(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);
  bool is_own(std::size_t index) const;

  LinkCore core_;
  std::shared_ptr<TxPort> port_;
  DatagramReader reader_;
  Parser parser_;
  AddressLookup remote_;
  AddressLookup local_;
  bool looking_up_ = false;
  bool to_many_ = false;  ///< broadcast or multicast: not connected
  SocketAddress own_;     ///< where our own packets to the group come from
  OpenDescriptor fd_;     ///< owned by the port's writer
  std::uint32_t drops_seen_ = 0;
  std::size_t poll_entry_ = 0;
};

/// The peers of a server, shared by the link's thread (which changes them) and the senders.
struct SharedPeers {
  SharedPeers(int max_peers, base::Duration expiry) : table(max_peers, expiry) {}
  base::Mutex mutex;
  PeerTable table CAS_GUARDED_BY(mutex);

  /// For the link's thread, which alone changes it, to look without the lock.
  PeerTable& own_table() CAS_THREAD_SAFETY(no_thread_safety_analysis) { return table; }
};

/// UDP on one port for many: who sends a packet here becomes a peer and gets packets until it falls
/// silent. Also serves as `udp` without a remote: then the newest sender is the one peer.
class UdpServerLink final : public Link {
 public:
  explicit UdpServerLink(LinkContext context);
  ~UdpServerLink() override { port_->detach(base::steady_now()); }

  void watch(PollSet& set, base::RunTime now) override;
  void serve(const PollSet& set, base::RunTime now) override;
  std::uint64_t received() const override { return core_.received(); }
  Arrivals arrivals() const override { return reader_.arrivals(); }
  std::shared_ptr<PacketPort> port() override { return port_; }

 private:
  void open(base::RunTime now);
  void read(base::RunTime now);
  void take_datagram(std::size_t index, base::RunTime now);
  std::optional<std::uint8_t> admit(std::size_t index, base::RunTime now);
  void on_second(base::RunTime now);
  void close(const std::string& reason, base::RunTime now);

  LinkCore core_;
  bool newest_only_;  ///< one peer: whoever spoke last
  std::shared_ptr<SharedPeers> peers_;
  std::shared_ptr<TxPort> port_;
  DatagramReader reader_;
  Parser parser_;
  AddressLookup local_;
  bool looking_up_ = false;
  OpenDescriptor fd_;  ///< owned by the port's writer
  std::uint32_t drops_seen_ = 0;
  std::size_t poll_entry_ = 0;
};

}  // namespace cas::casd
